// Histograms and tables of the results.
import type { Metrics, WeightedValues } from '../../wasm/index.js';
import { number, printTime } from './format.ts';

/** Percent of the weight in equal bins between low and high; the last takes its upper end too. */
export function histogram(data: WeightedValues, low: number, high: number, bins: number): number[] {
  const shares = new Array<number>(bins).fill(0);
  let total = 0;
  for (let i = 0; i < data.values.length; ++i) {
    const bin = Math.floor((bins * (data.values[i]! - low)) / (high - low));
    const weight = data.weights[i]!;
    total += weight;
    if (bin >= 0 && bin <= bins) shares[Math.min(bins - 1, bin)]! += weight;
  }
  return total > 0 ? shares.map((share) => (100 * share) / total) : shares;
}

export interface MetricRow {
  label: string;
  unit: string;
  curved: string;
  planar: string;
  /** Which of both is better; null where neither is, or where it is no matter of better. */
  better: 'curved' | 'planar' | null;
}

type Reader = (metrics: Metrics) => number | null | undefined;
interface MetricInfo {
  label: string;
  unit: string;
  read: Reader;
  /** 1: more is better, −1: less is better, 0: neither. */
  sense: 1 | -1 | 0;
  show?: (value: number) => string;
}

const METRICS: MetricInfo[] = [
  { label: 'Support free', unit: '% of area', read: (m) => m.support_free_area_percent, sense: 1 },
  { label: 'Mean excess overhang', unit: '°', read: (m) => m.support_free_mean_violation_deg, sense: -1 },
  { label: 'Without stair-steps', unit: '% of area', read: (m) => m.surface_quality_area_percent, sense: 1 },
  { label: 'Without stair-steps, painted', unit: '% of region', read: (m) => m.surface_quality_region_percent, sense: 1 },
  { label: 'Along the tension', unit: '% of tets', read: (m) => m.strength_critical_percent, sense: 1 },
  { label: 'Support material', unit: 'mm³', read: (m) => m.support_volume_mm3, sense: -1 },
  { label: 'Surface error, mean', unit: 'mm', read: (m) => m.surface_error_mm?.avg, sense: -1 },
  { label: 'Surface error, largest', unit: 'mm', read: (m) => m.surface_error_mm?.max, sense: -1 },
  { label: 'Strain, largest', unit: '%', read: (m) => percent(m.strain?.max), sense: -1 },
  { label: 'Strain, mean', unit: '%', read: (m) => percent(m.strain?.mean), sense: -1 },
  { label: 'Layers', unit: '', read: (m) => m.layers, sense: 0 },
  { label: 'Layer pieces', unit: '', read: (m) => m.components, sense: 0 },
  { label: 'Thinnest layer', unit: 'mm', read: (m) => m.thickness_mm?.min, sense: 0 },
  { label: 'Thickest layer', unit: 'mm', read: (m) => m.thickness_mm?.max, sense: 0 },
  { label: 'Outside thickness', unit: '%', read: (m) => m.thickness_outside_area_percent, sense: -1 },
  { label: 'Coverage', unit: '%', read: (m) => m.coverage_percent, sense: 1 },
  { label: 'Foldovers', unit: 'tets', read: (m) => m.foldovers, sense: -1 },
  { label: 'Gouging', unit: 'places', read: (m) => m.gouging_pairs, sense: -1 },
  { label: 'Islands', unit: 'places', read: (m) => m.islands, sense: -1 },
  { label: 'Path length', unit: 'm', read: (m) => (typeof m.path_length_mm === 'number' ? m.path_length_mm / 1000 : null), sense: 0 },
  { label: 'Material', unit: 'g', read: (m) => m.material_g, sense: -1 },
  { label: 'Print time', unit: '', read: (m) => m.print_time_s, sense: -1, show: printTime },
];

function percent(share: number | null | undefined): number | null {
  return typeof share === 'number' ? 100 * share : null;
}

/** Rows for what was computed for at least one of both. */
export function metricRows(curved: Metrics, planar: Metrics): MetricRow[] {
  const rows: MetricRow[] = [];
  for (const info of METRICS) {
    const a = info.read(curved), b = info.read(planar);
    const show = info.show ?? number;
    if (typeof a !== 'number' && typeof b !== 'number') continue;
    const texts = [a, b].map((value) => (typeof value === 'number' ? show(value) : '–'));
    let better: MetricRow['better'] = null;
    if (info.sense !== 0 && typeof a === 'number' && typeof b === 'number' && texts[0] !== texts[1]) {
      better = info.sense * (a - b) > 0 ? 'curved' : 'planar';
    }
    rows.push({ label: info.label, unit: info.unit, curved: texts[0]!, planar: texts[1]!, better });
  }
  return rows;
}

export interface HistogramPlot {
  title: string;
  /** What the horizontal axis counts, with its unit. */
  axis: string;
  low: number;
  high: number;
  curved: number[];
  planar: number[] | null;
  /** Where it is good to be. */
  good: [number, number][];
}

const W = 300, H = 150, LEFT = 30, RIGHT = 8, TOP = 8, BOTTOM = 34;

/** Curved as bars, planar as an outline; colours come from the page's style. */
export function histogramSvg(plot: HistogramPlot): string {
  const bins = plot.curved.length;
  const peak = Math.max(1, ...plot.curved, ...(plot.planar ?? []));
  const step = niceStep(peak / 3);
  const top = Math.ceil(peak / step) * step;
  const x = (value: number): number => LEFT + ((value - plot.low) / (plot.high - plot.low)) * (W - LEFT - RIGHT);
  const y = (share: number): number => H - BOTTOM - (share / top) * (H - TOP - BOTTOM);
  const at = (bin: number): number => x(plot.low + (bin / bins) * (plot.high - plot.low));
  const parts: string[] = [];
  const f = (v: number): string => v.toFixed(1);
  for (const [from, to] of plot.good) {
    parts.push(`<rect class="good" x="${f(x(from))}" y="${TOP}" width="${f(x(to) - x(from))}" height="${f(H - TOP - BOTTOM)}"/>`);
  }
  for (let share = 0; share <= top + 1e-9; share += step) {
    parts.push(`<line class="grid" x1="${LEFT}" x2="${W - RIGHT}" y1="${f(y(share))}" y2="${f(y(share))}"/>`);
    parts.push(`<text x="${LEFT - 4}" y="${f(y(share) + 3.5)}" text-anchor="end">${number(share)}</text>`);
  }
  plot.curved.forEach((share, bin) => {
    if (share > 0) {
      parts.push(`<rect class="curved" x="${f(at(bin))}" y="${f(y(share))}" width="${f(at(bin + 1) - at(bin) - 0.5)}" height="${f(H - BOTTOM - y(share))}"/>`);
    }
  });
  if (plot.planar) {
    const steps = plot.planar.map((share, bin) => `H${f(at(bin))}V${f(y(share))}H${f(at(bin + 1))}`).join('');
    parts.push(`<path class="planar" d="M${f(at(0))},${f(y(0))}${steps}V${f(y(0))}"/>`);
  }
  const tick = niceStep((plot.high - plot.low) / 5);
  for (let value = Math.ceil(plot.low / tick) * tick; value <= plot.high + 1e-9; value += tick) {
    parts.push(`<text x="${f(x(value))}" y="${H - BOTTOM + 13}" text-anchor="middle">${number(value)}</text>`);
  }
  parts.push(`<text x="${f((LEFT + W - RIGHT) / 2)}" y="${H - 5}" text-anchor="middle">${plot.axis}</text>`);
  return `<svg class="plot" viewBox="0 0 ${W} ${H}" role="img" aria-label="${plot.title}">${parts.join('')}</svg>`;
}

/** Values of one iteration after the other, from 0 up, as a line with a dot for each. */
export function iterationSvg({ title, axis, values }: { title: string; axis: string; values: number[] }): string {
  const step = niceStep(Math.max(...values, 1e-6) / 3);
  const top = step * Math.max(1, Math.ceil(Math.max(...values) / step));
  const x = (i: number): number => LEFT + 6 + (values.length > 1 ? (i / (values.length - 1)) * (W - LEFT - RIGHT - 12) : (W - LEFT - RIGHT - 12) / 2);
  const y = (value: number): number => H - BOTTOM - (value / top) * (H - TOP - BOTTOM);
  const f = (v: number): string => v.toFixed(1);
  const parts: string[] = [];
  for (let value = 0; value <= top * (1 + 1e-9); value += step) {
    parts.push(`<line class="grid" x1="${LEFT}" x2="${W - RIGHT}" y1="${f(y(value))}" y2="${f(y(value))}"/>`);
    parts.push(`<text x="${LEFT - 4}" y="${f(y(value) + 3.5)}" text-anchor="end">${number(value)}</text>`);
  }
  const every = Math.max(1, niceStep((values.length - 1) / 10));
  values.forEach((_, i) => {
    if (i % every === 0) parts.push(`<text x="${f(x(i))}" y="${H - BOTTOM + 13}" text-anchor="middle">${i + 1}</text>`);
  });
  parts.push(`<polyline class="line" points="${values.map((value, i) => `${f(x(i))},${f(y(value))}`).join(' ')}"/>`);
  values.forEach((value, i) => parts.push(`<circle class="curved" cx="${f(x(i))}" cy="${f(y(value))}" r="2.5"><title>${number(value)}°</title></circle>`));
  parts.push(`<text x="${f((LEFT + W - RIGHT) / 2)}" y="${H - 5}" text-anchor="middle">${axis}</text>`);
  return `<svg class="plot" viewBox="0 0 ${W} ${H}" role="img" aria-label="${title}: ${values.map((value) => `${number(value)}°`).join(', ')}">${parts.join('')}</svg>`;
}

/** 1, 2 or 5 times a power of ten, at least the given size. */
export function niceStep(size: number): number {
  const power = 10 ** Math.floor(Math.log10(Math.max(size, 1e-12)));
  const factor = [1, 2, 5, 10].find((one) => one * power >= size * (1 - 1e-9)) ?? 10;
  return factor * power;
}

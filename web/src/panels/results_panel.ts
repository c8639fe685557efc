// What came out: figures of curved against planar layers, histograms, warnings, files.
import type { ExportInfo, HistogramData, Point } from '../../../wasm/index.js';
import type { App } from '../app.ts';
import { histogram, histogramSvg, iterationSvg, metricRows } from '../analysis.ts';
import type { HistogramPlot } from '../analysis.ts';
import { download, h, icon, replace } from '../dom.ts';

export interface ResultActions {
  picture(): Promise<void>;
  saveProject(): Promise<void>;
  mark(places: readonly Point[]): void;
}

/** Programs first: they are what a person came for. */
const ORDER = ['program.gcode', 'duet.gcode', 'program.script', 'joints.csv', 'waypoints.csv', 'fields.vtu', 'stress.csv', 'report.json', 'job.json'];
const rank = (name: string): number => (ORDER.indexOf(name) + ORDER.length + 1) % (ORDER.length + 1);

export function makeResultsPanel(app: App, host: HTMLElement, actions: ResultActions): { saveProgram(): Promise<void>; complete(): Promise<unknown> } {
  const exports = h('section', { class: 'group' });
  const warnings = h('section', { class: 'group' });
  const table = h('section', { class: 'group' });
  const plots = h('section', { class: 'group' });
  const stale = h('p', { class: 'note warn stale-note', hidden: true }, icon('warning'), 'Settings have changed since: slice again to update.');
  replace(host, stale, exports, table, plots, warnings);
  let round = 0;

  async function showFiles(): Promise<void> {
    const turn = ++round;
    if (app.running && exports.querySelector('[data-export]')) {
      // They keep their place until the run has ended.
      for (const one of exports.querySelectorAll('button')) one.disabled = true;
      return;
    }
    const infos = app.engine && app.model && app.has('mesh') && !app.running ? await app.exports().catch(() => []) : [];
    if (turn !== round) return;
    const single = infos.filter((info) => !info.name.startsWith('layers/') && !info.name.endsWith('.svg'))
      .sort((a, b) => rank(a.name) - rank(b.name));
    const layers = infos.filter((info) => info.name.startsWith('layers/'));
    const button = (text: string, title: string, onclick: () => void, id?: string): HTMLElement =>
      h('button', { class: 'button', type: 'button', title, onclick, ...(id ? { 'data-export': id } : {}) }, icon('down'), text);
    replace(exports, h('h2', {}, 'Files'),
      infos.length === 0 ? h('p', { class: 'muted' }, app.running ? 'Files are listed when the run has ended.' : 'Slice the part to get its files.') : null,
      infos.length > 0 ? h('div', { class: 'grid2' },
        ...single.map((info) => button(fileTitle(info.name), info.name, () => void save(info), info.name)),
        layers.length > 0 ? button('Layers PLY', `${layers.length} files layers/*.ply in one ZIP`, () => void saveLayers(layers), 'layers') : null,
        button('Project', 'Model, settings and loads: opens again here, and natively', () => void actions.saveProject(), 'project'),
        button('Picture', 'What the view shows, as PNG', () => void actions.picture(), 'picture')) : null);
  }
  async function save(info: ExportInfo): Promise<void> {
    try {
      download(`${stem(app)}-${info.name}`, (await app.exportFile(info.name)) as Uint8Array<ArrayBuffer>, info.type);
    } catch (error) {
      app.fail(error, `${info.name} could not be made`);
    }
  }
  async function saveLayers(infos: ExportInfo[]): Promise<void> {
    try {
      const { writeZip } = await import('../../../wasm/index.js');
      const files = [];
      for (const info of infos) files.push({ name: info.name, bytes: await app.exportFile(info.name) });
      download(`${stem(app)}-layers.zip`, writeZip(files), 'application/zip');
    } catch (error) {
      app.fail(error, 'The layers could not be saved');
    }
  }

  let figures = 0;
  async function showFigures(): Promise<void> {
    const turn = ++figures;
    const [metrics, curved, planar, deformation] = await Promise.all([
      app.result('metrics'), app.result('histogramData', 'curved'), app.result('histogramData', 'planar'), app.result('deformation'),
    ]);
    if (turn !== figures) return;  // newer ones are on their way
    const rows = metrics ? metricRows(metrics.curved, metrics.planar) : [];
    replace(table, rows.length > 0 && h('h2', {}, 'Curved against planar'), rows.length > 0 && h('table', { class: 'metrics' },
      h('thead', {}, h('tr', {}, h('th', {}, ''), h('th', { scope: 'col' }, 'curved'), h('th', { scope: 'col' }, 'planar'))),
      h('tbody', {}, ...rows.map((row) => h('tr', {},
        h('td', {}, row.label, row.unit && h('small', {}, row.unit)),
        h('td', { class: row.better === 'curved' ? 'better' : '' }, row.curved),
        h('td', { class: row.better === 'planar' ? 'better' : '' }, row.planar))))));
    const charts = curved ? makePlots(app, curved, planar) : [];
    replace(plots, charts.length > 0 && h('h2', {}, 'Distributions'),
      charts.length > 0 && h('div', { class: 'keys' }, h('span', {}, h('i', {}), 'curved'), h('span', {}, h('i', { class: 'planar' }), 'planar')));
    for (const plot of charts) {
      const figure = h('figure', { style: 'margin: 0' }, h('figcaption', { class: 'small' }, plot.title));
      figure.insertAdjacentHTML('beforeend', histogramSvg(plot));
      plots.append(figure);
    }
    if (deformation && deformation.residuals.length > 0) {
      const degrees = [...deformation.residuals].map((value) => (value * 180) / Math.PI);
      const figure = h('figure', { style: 'margin: 0' }, h('figcaption', { class: 'small' }, 'Π: mean angle to the objectives after each iteration'));
      figure.insertAdjacentHTML('beforeend', iterationSvg({ title: 'Π after each iteration', axis: 'iteration, degrees', values: degrees }));
      plots.append(figure);
    }
  }

  function showWarnings(): void {
    const found = app.warnings();
    replace(warnings, found.length > 0 && h('h2', {}, 'Notes', h('small', {}, String(found.length))),
      found.length > 0 && h('ul', { class: 'list' }, ...found.map(({ warning }) => h('li', { class: 'note quiet' }, warning.message,
        warning.where.length > 0 ? h('span', {}, ' ', h('button', { class: 'link', type: 'button', onclick: () => actions.mark(warning.where) }, 'Show where')) : null))));
    stale.hidden = !app.isStale('layers') && !app.isStale('metrics');
  }

  let shown: Promise<unknown> = Promise.resolve();
  const also = (work: Promise<void>): void => { shown = Promise.all([shown, work]); };
  for (const event of ['model', 'stages', 'running'] as const) app.on(event, showWarnings);
  for (const event of ['model', 'running'] as const) app.on(event, () => also(showFiles()));
  app.on('model', () => also(showFigures()));
  app.on('done', (stage) => {
    if (stage === 'layers' || stage === 'metrics') also(showFigures());
  });
  also(showFiles());
  return {
    /** Until everything that is there is shown. */
    complete: () => shown,
    /** The first program that the machine asks for. */
    async saveProgram() {
      const found = (await app.exports()).filter((info) => info.stage === 'export').sort((a, b) => rank(a.name) - rank(b.name))[0];
      if (found) await save(found);
    },
  };
}

/** The model's name without its endings. */
export const stem = (app: App): string => (app.model?.file.name ?? 'part').replace(/\.gz$/i, '').replace(/\.[^.]+$/, '');

function fileTitle(name: string): string {
  const titles: Record<string, string> = {
    'program.gcode': 'G-code', 'duet.gcode': 'G-code (Duet)', 'program.script': 'URScript', 'waypoints.csv': 'Waypoints CSV', 'fields.vtu': 'Fields VTU', 'report.json': 'Report', 'job.json': 'Settings',
    'stress.csv': 'Stress CSV', 'joints.csv': 'Joints CSV',
  };
  return titles[name] ?? name;
}

function makePlots(app: App, curved: HistogramData, planar: HistogramData | null): HistogramPlot[] {
  const alpha = Number(app.param('objectives.alpha') ?? 45);
  const plots: HistogramPlot[] = [{
    title: 'Overhang: angle of the surface against its layer', axis: 'degrees, share of area in %', low: 0, high: 180,
    curved: histogram(curved.supportFree, 0, 180, 36), planar: planar && histogram(planar.supportFree, 0, 180, 36), good: [[0, 90 + alpha]],
  }, {
    title: 'Stair-steps: 0° flat, 90° upright', axis: 'degrees, share of area in %', low: 0, high: 90,
    curved: histogram(curved.surfaceQuality, 0, 90, 30), planar: planar && histogram(planar.surfaceQuality, 0, 90, 30), good: [[0, 10], [80, 90]],
  }];
  if (curved.strength.values.length > 0) {
    plots.push({
      title: 'Strength: angle of the tension to the layer', axis: 'degrees, share of critical tets in %', low: 0, high: 90,
      curved: histogram(curved.strength, 0, 90, 30), planar: planar && histogram(planar.strength, 0, 90, 30), good: [[0, 10]],
    });
  }
  if (curved.thickness.values.length > 0) {
    const nozzle = Number(app.param('nozzle.diameter') ?? 1);
    const low = Number(app.param('layers.min_thickness')) || 0.4 * nozzle, high = Number(app.param('layers.max_thickness')) || nozzle;
    const end = 1.5 * high;
    plots.push({
      title: 'Layer thickness', axis: 'mm, share of layer area in %', low: 0, high: end, curved: histogram(curved.thickness, 0, end, 45),
      planar: planar && planar.thickness.values.length > 0 ? histogram(planar.thickness, 0, end, 45) : null, good: [[low, high]],
    });
  }
  return plots;
}

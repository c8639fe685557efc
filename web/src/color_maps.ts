// Numbers to colours. Maps are given by a few stops, interpolated in linear RGB steps of 1/255.

export type Rgb = [r: number, g: number, b: number];  // 0 … 255

const hex = (text: string): Rgb => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16)) as Rgb;

/** Stops from low to high. Viridis and the diverging map read well for people who do not tell red from green. */
const STOPS = {
  viridis: ['#440154', '#46327e', '#365c8d', '#277f8e', '#1fa187', '#4ac16d', '#a0da39', '#fde725'],
  diverging: ['#2d5aa8', '#6a9bd1', '#b9d3e8', '#e8e6e1', '#f2c3a0', '#d97b4f', '#a93226'],
  warm: ['#f3e9d2', '#f4c98b', '#ec9a57', '#d8643c', '#a8322f', '#6d1a2c'],
} as const;
export type MapName = keyof typeof STOPS;

const tables = new Map<MapName, Uint8Array>();

/** 256 colours of a map, rgb after rgb. */
export function table(name: MapName): Uint8Array {
  let found = tables.get(name);
  if (!found) {
    const stops = STOPS[name].map(hex);
    found = new Uint8Array(3 * 256);
    for (let i = 0; i < 256; ++i) {
      const at = (i / 255) * (stops.length - 1);
      const low = Math.min(stops.length - 2, Math.floor(at)), t = at - low;
      for (let k = 0; k < 3; ++k) found[3 * i + k] = Math.round((1 - t) * stops[low]![k]! + t * stops[low + 1]![k]!);
    }
    tables.set(name, found);
  }
  return found;
}

/** Values between low and high as rgb bytes; what is no number is grey. */
export function colorize(values: ArrayLike<number>, map: MapName, low: number, high: number, out?: Uint8Array, stride = 3): Uint8Array {
  const colors = table(map);
  const result = out ?? new Uint8Array(stride * values.length);
  const factor = high > low ? 255 / (high - low) : 0;
  for (let i = 0; i < values.length; ++i) {
    const value = values[i]!;
    if (Number.isNaN(value)) {
      result[stride * i] = result[stride * i + 1] = result[stride * i + 2] = 150;
      continue;
    }
    const entry = 3 * Math.min(255, Math.max(0, Math.round((value - low) * factor)));
    result[stride * i] = colors[entry]!;
    result[stride * i + 1] = colors[entry + 1]!;
    result[stride * i + 2] = colors[entry + 2]!;
  }
  return result;
}

/** Kinds of toolpaths, in the order of pathKinds; the last is for travels. */
export const KIND_COLORS: Rgb[] = [hex('#e2843c'), hex('#3f86c6'), hex('#5fae6b')];
export const TRAVEL_COLOR: Rgb = hex('#9a8fd0');
/** Marks what goes wrong: overhang, gouging, defects. */
export const WARNING_COLOR: Rgb = hex('#e0453a');

/** Neighbouring layers in tones that can be told apart, repeating after six. */
export const LAYER_TONES: Rgb[] = ['#4f8fc0', '#7fb2d6', '#5aa39b', '#8cc7b5', '#c0a25a', '#dcc48a'].map(hex);
export const layerColor = (layer: number): Rgb => LAYER_TONES[layer % LAYER_TONES.length]!;

export const css = ([r, g, b]: Rgb): string => `rgb(${r} ${g} ${b})`;

/** The map as a CSS gradient from low (left) to high. */
export function gradient(name: MapName): string {
  return `linear-gradient(to right, ${STOPS[name].join(', ')})`;
}

/** Least and largest value, leaving out what is no number; [0, 1] of nothing. */
export function extent(values: ArrayLike<number>): [number, number] {
  let low = Infinity, high = -Infinity;
  for (let i = 0; i < values.length; ++i) {
    const value = values[i]!;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : [0, 1];
}

/** The range between two quantiles, so that few outliers do not take all the colours. */
export function robustExtent(values: ArrayLike<number>, cut = 0.01): [number, number] {
  const step = Math.max(1, Math.floor(values.length / 20000));
  const sample: number[] = [];
  for (let i = 0; i < values.length; i += step) if (Number.isFinite(values[i]!)) sample.push(values[i]!);
  if (sample.length === 0) return [0, 1];
  sample.sort((a, b) => a - b);
  return [sample[Math.floor(cut * (sample.length - 1))]!, sample[Math.ceil((1 - cut) * (sample.length - 1))]!];
}

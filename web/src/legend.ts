// What the colours mean.
import { css, gradient } from './color_maps.ts';
import type { MapName, Rgb } from './color_maps.ts';
import { h, replace } from './dom.ts';
import { number } from './format.ts';

export interface LegendContent {
  title: string;
  unit?: string;
  map?: MapName;
  low?: number;
  high?: number;
  keys?: { color: Rgb; text: string }[];
  note?: string;
}

export function showLegend(host: HTMLElement, content: LegendContent | null): void {
  if (!content) {
    replace(host);
    return;
  }
  const { title, unit, map, low, high, keys, note } = content;
  replace(host, h('b', {}, title),
    map && low !== undefined && high !== undefined && h('div', {}, h('div', { class: 'scale', style: `background:${gradient(map)}` }),
      h('div', { class: 'ends' }, h('span', {}, number(low)), h('span', {}, `${number(high)} ${unit ?? ''}`))),
    ...(keys ?? []).map((key) => h('span', { class: 'key' }, h('i', { style: `background:${css(key.color)}` }), key.text)),
    note && h('span', { class: 'muted' }, note));
}

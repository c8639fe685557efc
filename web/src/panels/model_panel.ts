// The file: what it holds, what is wrong with it, its unit and how it stands on the plate.
import type { Defect } from '../../../wasm/index.js';
import type { App } from '../app.ts';
import { h, icon, replace, segmented } from '../dom.ts';
import type { Example } from '../examples.ts';
import { count, number } from '../format.ts';
import { formatRotation, parseRotation, turned } from '../rotation.ts';

export interface ModelActions {
  choose(): void;
  example(example: Example): void;
  /** Whether a click on the part lays the face below it on the plate. */
  setLaying(on: boolean): void;
  /** Marks places of the file's frame; none clears. */
  mark(places: readonly [number, number, number][]): void;
}

const UNITS: [name: string, factor: number][] = [['mm', 1], ['cm', 10], ['m', 1000], ['inch', 25.4]];

const DEFECTS: [key: 'open_edges' | 'nonmanifold_edges' | 'inconsistent_edges' | 'nonmanifold_vertices' | 'degenerate_triangles' | 'duplicate_triangles' | 'self_intersections', text: string][] = [
  ['open_edges', 'open edges'], ['nonmanifold_edges', 'edges with more than two faces'], ['inconsistent_edges', 'edges between faces turned against each other'],
  ['nonmanifold_vertices', 'points where the surface touches itself'], ['degenerate_triangles', 'degenerate triangles'],
  ['duplicate_triangles', 'duplicate triangles'], ['self_intersections', 'self-intersections'],
];

export function makeExamples(examples: Example[], onchoose: (example: Example) => void): HTMLElement {
  return h('div', { class: 'examples' }, ...examples.map((example) =>
    h('button', { class: 'example', type: 'button', title: example.title, 'data-example': example.file, onclick: () => onchoose(example) },
      h('img', { src: `examples/${example.file.replace('.stl', '.webp')}`, alt: '', width: 120, height: 90 }), example.name)));
}

export function makeModelPanel(app: App, host: HTMLElement, examples: Example[], actions: ModelActions): { stopLaying(): void } {
  const report = h('section', { class: 'group' });
  const place = h('section', { class: 'group' });
  const angles = [0, 1, 2].map((axis) => h('input', {
    type: 'text', inputmode: 'decimal', 'aria-label': `Rotation about ${'xyz'[axis]}, degrees`, onchange: readAngles,
  }));
  const lay = h('button', { class: 'button', type: 'button', 'aria-pressed': 'false', onclick: () => setLaying(lay.getAttribute('aria-pressed') !== 'true') }, 'Lay a face down');
  const units = h('select', { 'aria-label': 'Unit of the file', onchange: () => app.setParams({ 'input.scale': Number(units.value) }) },
    ...UNITS.map(([name, factor]) => h('option', { value: factor }, name)));
  const up = segmented('Up axis of the file', [{ value: 'z', text: 'z up' }, { value: 'y', text: 'y up' }], 'z', (value) => app.setParams({ 'input.up': value }));
  const found = h('p', { class: 'small muted' });

  function setLaying(on: boolean): void {
    lay.setAttribute('aria-pressed', String(on));
    actions.setLaying(on);
  }
  function turn(axis: 0 | 1 | 2): void {
    app.setParams({ 'input.rotate': formatRotation(turned(app.rotation(), axis, 90)) });
  }
  function readAngles(): void {
    const parsed = parseRotation(angles.map((input) => input.value || '0').join(','));
    if (parsed) app.setParams({ 'input.rotate': formatRotation(parsed) });
    else showPlace();
  }

  function showReport(): void {
    const { model, inspection } = app;
    if (!model) {
      replace(report, h('p', { class: 'muted' }, 'No part yet. Open a file or take an example.'));
      return;
    }
    const facts: [string, string][] = [['File', model.file.name]];
    // What is not known yet keeps its line.
    if (!inspection) {
      facts.push(['Size', '…'], ['Triangles', count(model.surface.indices.length / 3)], ['Volume', '…']);
    } else {
      facts.push(['Size', inspection.size_mm.map((size) => number(size)).join(' × ') + ' mm']);
      if (inspection.is_volume) facts.push(['Tets', count(inspection.tets ?? 0)]);
      else facts.push(['Triangles', count(inspection.triangles ?? model.surface.indices.length / 3)]);
      const volume = inspection.volume_after_repair_mm3 ?? inspection.volume_mm3;
      if (volume) facts.push(['Volume', `${number(volume / 1000)} cm³`]);
      if (inspection.parts && inspection.parts.length > 1) facts.push(['Parts', String(inspection.parts.length)]);
    }
    replace(report, h('h2', {}, 'Part'),
      h('dl', { class: 'facts' }, ...facts.flatMap(([key, value]) => [h('dt', {}, key), h('dd', {}, value)])), condition());
  }

  /** Defects and what repair does about them. */
  function condition(): HTMLElement {
    const { inspection } = app;
    if (!inspection) return h('p', { class: 'note' }, 'Checking the surface…');
    if (inspection.is_volume) return h('p', { class: 'note' }, 'A volume mesh: its tets are used as they are.');
    if (inspection.refused) return h('p', { class: 'note bad' }, inspection.refused);
    const defects = DEFECTS.map(([key, text]) => ({ text, defect: inspection[key] }))
      .filter((one): one is { text: string; defect: Defect } => (one.defect?.count ?? 0) > 0);
    if (defects.length === 0) return h('p', { class: 'note' }, 'Closed and sound.');
    const end = inspection.valid_after_repair ? 'Repaired by itself:' : 'Repaired as far as possible; the rest is rebuilt as a solid:';
    return h('div', { class: 'note warn', id: 'defects' }, end,
      h('ul', { class: 'list' }, ...defects.map(({ text, defect }) => h('li', {},
        h('button', { class: 'link', type: 'button', title: 'Show where', onclick: () => actions.mark(defect.where) }, `${count(defect.count)} ${text}`)))));
  }

  function showPlace(): void {
    place.hidden = !app.model;
    const rotate = String(app.param('input.rotate') ?? '0,0,0');
    const parsed = parseRotation(rotate);
    angles.forEach((input, axis) => {
      if (document.activeElement !== input) input.value = parsed ? number(parsed[axis]!) : '';
      input.placeholder = parsed ? '' : rotate;
    });
    const scale = String(app.param('input.scale') ?? 1);
    if (![...units.options].some((option) => option.value === scale)) units.append(h('option', { value: scale }, `× ${scale}`));
    units.value = scale;
    up.set(app.param<'z' | 'y'>('input.up') ?? 'z');
    found.textContent = parsed ? '' : rotate === 'auto' ? 'Turned to the least overhang and support.' : 'The largest flat face lies on the plate.';
    found.hidden = parsed !== null;
  }

  replace(host, h('section', { class: 'group' },
    h('div', { class: 'row' }, h('button', { class: 'button primary', type: 'button', id: 'open-model', onclick: actions.choose }, icon('open'), 'Open a file…'),
      h('span', { class: 'small muted' }, 'or drop it anywhere'))),
    report, place, h('section', { class: 'group' }, h('h2', {}, 'Examples'), makeExamples(examples, actions.example)));
  replace(place, h('h2', {}, 'On the plate'),
    h('div', { class: 'row spread' }, h('label', { class: 'row', style: 'flex-wrap: nowrap' }, 'Unit', units), up.element),
    h('div', { class: 'grid3' }, lay,
      h('button', { class: 'button', type: 'button', title: 'The largest flat face down', onclick: () => app.setParams({ 'input.rotate': 'flat' }) }, 'Flattest'),
      h('button', { class: 'button', type: 'button', title: 'Least overhang and support', onclick: () => app.setParams({ 'input.rotate': 'auto' }) }, 'Auto')),
    h('div', { class: 'grid3' }, ...([0, 1, 2] as const).map((axis) =>
      h('button', { class: 'button', type: 'button', 'aria-label': `Turn by 90 degrees about ${'xyz'[axis]}`, onclick: () => turn(axis) }, `${'xyz'[axis]} + 90°`))),
    h('div', { class: 'vector' }, ...angles.map((input, axis) => h('label', {}, 'xyz'[axis]!, input))), found);

  app.on('model', () => { showReport(); showPlace(); });
  app.on('inspection', showReport);
  app.on('settings', () => { showReport(); showPlace(); });
  showReport();
  showPlace();
  return { stopLaying: () => setLaying(false) };
}

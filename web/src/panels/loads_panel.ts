// Loads, and where surface and strength matter: regions that are picked or painted on the part.
import type { App } from '../app.ts';
import { h, iconButton, replace, segmented, slider } from '../dom.ts';
import { css } from '../color_maps.ts';
import type { Rgb } from '../color_maps.ts';
import { MATERIALS, caseNumbers, hasLoads, loadProblems, paintProblems } from '../load_case.ts';
import type { LoadRegion, Loads, RegionKind } from '../load_case.ts';
import type { LoadFileKind } from '../protocol.ts';
import type { Vec } from '../rotation.ts';

export type LoadTool = 'pick' | 'paint' | 'erase';

/** What the views need of the editor. */
export interface LoadEditor {
  /** The region that clicks go to; null while the editor is closed or empty. */
  active(): LoadRegion | null;
  tool(): LoadTool;
  /** Degrees to which a picked face spreads. */
  angle(): number;
  /** Radius of the brush as a share of the part's size. */
  brush(): number;
  update(region: LoadRegion, step?: string): void;
}

const KINDS: Record<RegionKind, { name: string; palette: Rgb[] }> = {
  fixed: { name: 'Fixed', palette: [[70, 120, 200], [96, 100, 190], [60, 150, 170]] },
  force: { name: 'Force', palette: [[214, 98, 48], [200, 70, 110], [205, 150, 40]] },
  surface: { name: 'Surface quality', palette: [[74, 160, 96]] },
  critical: { name: 'Critical', palette: [[150, 80, 180]] },
};
export function regionColor(loads: Loads, region: LoadRegion): Rgb {
  const same = loads.regions.filter((one) => one.kind === region.kind);
  const { palette } = KINDS[region.kind];
  return palette[Math.max(0, same.findIndex((one) => one.id === region.id)) % palette.length]!;
}

export function makeLoadsPanel(app: App, host: HTMLElement, visible: () => boolean, onedit: () => void): LoadEditor {
  let activeId: number | null = null;
  let tool: LoadTool = 'pick';
  let angle = 25;
  let brush = 0.06;
  const list = h('div', { class: 'group' });
  const problems = h('div', { class: 'group' });
  const fromFile = h('div', { class: 'group' });
  const editor = h('div', { class: 'group' });
  const material = h('select', { 'aria-label': 'Material', onchange: () => app.change({ loads: { ...app.settings.loads, material: material.value } }) },
    ...MATERIALS.map((name) => h('option', { value: name }, name)));
  const stressFile = fileInput('.csv,.vtu', 'Stress file', (file) => void readStress(file));
  const loadFile = fileInput('.json', 'Load case file', (file) => void readLoads(file));
  const tools = segmented('Tool', [
    { value: 'pick', text: 'Pick', title: 'A click takes the face and what continues it smoothly' },
    { value: 'paint', text: 'Paint', title: 'Drag over the part' },
    { value: 'erase', text: 'Erase', title: 'Drag or click to take away' },
  ], tool, (value) => { tool = value; showTool(); onedit(); });
  const spread = slider({ label: 'Spread to', min: 1, max: 60, step: 1, value: angle, show: (value) => `${value}°`, oninput: (value) => { angle = value; } });
  const size = slider({ label: 'Brush', min: 0.02, max: 0.2, step: 0.01, value: brush, show: (value) => `${Math.round(100 * value)} %`, oninput: (value) => { brush = value; } });

  function showTool(): void {
    spread.element.hidden = tool !== 'pick';
    size.element.hidden = tool === 'pick';
  }

  function add(kind: RegionKind): void {
    const { loads } = app.settings;
    const id = Math.max(0, ...loads.regions.map((region) => region.id)) + 1;
    const number = loads.regions.filter((region) => region.kind === kind).length + 1;
    const first = kind === 'fixed' && number === 1;
    const region: LoadRegion = {
      id, kind, name: `${KINDS[kind].name} ${number}`, plate: first, patches: [], force: [0, 0, -100], axes: 'xyz', loadCase: 0,
    };
    activeId = id;
    app.change({ loads: { ...loads, regions: [...loads.regions, region] } });
  }
  function update(region: LoadRegion, step = ''): void {
    const { loads } = app.settings;
    app.change({ loads: { ...loads, regions: loads.regions.map((one) => (one.id === region.id ? region : one)) } }, step);
  }
  function remove(region: LoadRegion): void {
    const { loads } = app.settings;
    app.change({ loads: { ...loads, regions: loads.regions.filter((one) => one.id !== region.id) } });
  }

  async function readStress(file: File): Promise<void> {
    app.change({ stress: { name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) } });
  }
  async function readLoads(file: File): Promise<void> {
    setFile('loads', { name: file.name, text: await file.text() });
  }

  function setFile(kind: LoadFileKind, file: { name: string; text: string } | null): void {
    app.change({ files: { ...app.settings.files, [kind]: file } });
  }

  function card(region: LoadRegion): HTMLElement {
    const { loads } = app.settings;
    const name = h('input', { type: 'text', value: region.name, 'aria-label': 'Name', onchange: () => update({ ...region, name: name.value.trim() || region.name }) });
    const faces = region.patches.length === 0 ? 'no faces' : `${region.patches.length} ${region.patches.length === 1 ? 'patch' : 'patches'}`;
    const plate = h('input', { type: 'checkbox', checked: region.plate, onchange: () => update({ ...region, plate: plate.checked }) });
    return h('div', { class: `load${region.id === activeId ? ' active' : ''}`, 'data-region': region.id, onclick: () => activate(region.id) },
      h('div', { class: 'row', style: 'flex-wrap: nowrap' }, h('i', { class: 'swatch', style: `background:${css(regionColor(loads, region))}` }), name,
        iconButton('trash', `Remove ${region.name}`, (event) => { event.stopPropagation(); remove(region); })),
      h('div', { class: 'row spread small' }, h('span', { class: 'muted' }, faces), region.kind !== 'surface' && h('label', { class: 'check' }, plate, 'contact with the plate')),
      region.kind === 'force' ? vector(region) : region.kind === 'fixed' ? axes(region) : null,
      region.kind === 'force' || region.kind === 'fixed' ? caseChoice(region) : null);
  }
  /** Shown once there is more than one load, or more than one case. */
  function caseChoice(region: LoadRegion): HTMLElement | null {
    const { loads } = app.settings;
    const numbers = caseNumbers(loads);
    if (numbers.length === 0 && loads.regions.filter((one) => one.kind === 'force').length < 2) return null;
    const next = (numbers.at(-1) ?? 0) + 1;
    const select = h('select', { 'aria-label': `${region.name} acts in`, onchange: () => update({ ...region, loadCase: Number(select.value) }) },
      h('option', { value: 0 }, 'every load case'), ...numbers.map((number) => h('option', { value: number }, `case ${number}`)), h('option', { value: next }, `case ${next} (new)`));
    select.value = String(region.loadCase);
    return h('label', { class: 'row small', style: 'flex-wrap: nowrap' }, h('span', { class: 'muted' }, 'Acts in'), select);
  }
  function vector(region: LoadRegion): HTMLElement {
    return h('div', { class: 'vector' }, ...([0, 1, 2] as const).map((axis) => {
      const input = h('input', { type: 'number', step: 'any', value: Math.round(region.force[axis] * 100) / 100, 'aria-label': `${region.name}, force along ${'xyz'[axis]}, N`, onchange: () => {
        const force = [...region.force] as Vec;
        force[axis] = Number.isFinite(input.valueAsNumber) ? input.valueAsNumber : 0;
        update({ ...region, force });
      } });
      return h('label', {}, `${'xyz'[axis]}`, input, axis === 2 && 'N');
    }));
  }
  function axes(region: LoadRegion): HTMLElement {
    return h('div', { class: 'row small' }, h('span', { class: 'muted' }, 'Holds'), ...'xyz'.split('').map((axis) => {
      const input = h('input', { type: 'checkbox', checked: region.axes.includes(axis), 'aria-label': `${region.name} holds along ${axis}`, onchange: () => {
        const next = 'xyz'.split('').filter((one) => (one === axis ? input.checked : region.axes.includes(one))).join('');
        update({ ...region, axes: next || region.axes });
      } });
      return h('label', { class: 'check' }, input, axis);
    }));
  }

  function activate(id: number): void {
    if (activeId === id) return;
    activeId = id;
    for (const element of list.querySelectorAll('.load')) element.classList.toggle('active', element.getAttribute('data-region') === String(id));
    onedit();
  }

  function show(): void {
    const { loads, files, stress } = app.settings;
    if (!loads.regions.some((region) => region.id === activeId)) activeId = loads.regions[0]?.id ?? null;
    material.value = loads.material;
    replace(list, ...loads.regions.map(card));
    list.hidden = editor.hidden = loads.regions.length === 0;
    const found = [...(hasLoads(loads) ? loadProblems(loads) : []), ...paintProblems(loads, 'surface'), ...paintProblems(loads, 'critical')];
    const has = (kind: RegionKind): boolean => loads.regions.some((region) => region.kind === kind);
    const off = (key: 'objectives.strength' | 'objectives.surface_quality'): boolean => Number(app.param(key) ?? 0) === 0;
    const switchOn = (text: string, key: 'objectives.strength' | 'objectives.surface_quality'): HTMLElement => h('p', { class: 'note' }, text, ' ',
      h('button', { class: 'link', type: 'button', onclick: () => app.setParams({ 'objectives.support_free': 0.7, [key]: 0.3 }) }, 'Switch it on'));
    replace(problems, ...found.map((text) => h('p', { class: 'note warn' }, text)),
      found.length === 0 && (hasLoads(loads) || has('critical')) && off('objectives.strength') && switchOn('Strength is switched off: layers do not follow the tension.', 'objectives.strength'),
      has('surface') && off('objectives.surface_quality') && switchOn('Surface quality is switched off.', 'objectives.surface_quality'));
    problems.hidden = problems.childElementCount === 0;
    replace(fromFile,
      files.loads && note(`Load case from “${files.loads.name}”: used instead of the regions above.`, () => setFile('loads', null)),
      files.surface && note(`Surface quality counts in the region of “${files.surface.name}”.`, () => setFile('surface', null)),
      files.critical && note(`Critical region from “${files.critical.name}”.`, () => setFile('critical', null)),
      stress && note(`Stress from “${stress.name}”.`, () => app.change({ stress: null })),
      h('div', { class: 'row' }, h('button', { class: 'button', type: 'button', onclick: () => loadFile.click() }, 'Load case file…'),
        h('button', { class: 'button', type: 'button', onclick: () => stressFile.click(), disabled: !app.inspection?.is_volume, title: 'Stress of every tet, for volume meshes' }, 'Stress file…')),
      loadFile, stressFile);
    onedit();
  }
  function note(text: string, onremove: () => void): HTMLElement {
    return h('p', { class: 'note row spread' }, text, h('button', { class: 'link', type: 'button', onclick: onremove }, 'Remove'));
  }

  replace(editor, tools.element, spread.element, size.element,
    h('p', { class: 'small muted' }, 'Click or drag on the part for the region with the coloured border. Drag the tip of an arrow to aim its force.'));
  replace(host,
    h('section', { class: 'group' }, h('h2', {}, 'Loads'),
      h('p', { class: 'small muted' }, 'What holds the part and what pulls at it. Layers then follow the largest tension.'),
      h('div', { class: 'grid2' },
        h('button', { class: 'button', type: 'button', id: 'add-fixed', onclick: () => add('fixed') }, 'Add fixed region'),
        h('button', { class: 'button', type: 'button', id: 'add-force', onclick: () => add('force') }, 'Add force')),
      h('label', { class: 'slider', style: 'grid-template-columns: 112px 1fr' }, h('span', {}, 'Material'), material)),
    h('section', { class: 'group' }, h('h2', {}, 'Where it matters'),
      h('div', { class: 'grid2' },
        h('button', { class: 'button', type: 'button', id: 'add-surface', title: 'Surface quality counts on these faces alone', onclick: () => add('surface') }, 'Paint surface'),
        h('button', { class: 'button', type: 'button', id: 'add-critical', title: 'Critical for strength, beside the largest tension', onclick: () => add('critical') }, 'Paint critical')),
      h('p', { class: 'small muted' }, 'Surface quality then counts on the painted faces alone; critical regions add to the largest tension.')),
    editor, list, problems, h('section', { class: 'group' }, h('h2', {}, 'From files'), fromFile));
  showTool();
  app.on('settings', show);
  app.on('inspection', show);
  show();
  return {
    active: () => (visible() ? (app.settings.loads.regions.find((region) => region.id === activeId) ?? null) : null),
    tool: () => tool,
    angle: () => angle,
    brush: () => brush,
    update,
  };
}

function fileInput(accept: string, label: string, onfile: (file: File) => void): HTMLInputElement {
  const input = h('input', { type: 'file', accept, hidden: true, 'aria-label': label, onchange: () => {
    const file = input.files?.[0];
    if (file) onfile(file);
    input.value = '';
  } });
  return input;
}

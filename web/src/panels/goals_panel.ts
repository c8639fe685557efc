// What the part should be good at: presets, the preference triangle, three sliders; and how fine the mesh is.
import type { App } from '../app.ts';
import { h, replace, slider } from '../dom.ts';
import { CORNERS, pointOf, weightsAt } from '../objectives.ts';
import type { Weights } from '../objectives.ts';
import { DETAIL_PRESETS, GOAL_PRESETS, matchesPreset } from '../settings.ts';
import type { Preset } from '../settings.ts';

const KEYS = ['objectives.support_free', 'objectives.strength', 'objectives.surface_quality'] as const;
const NAMES = ['Support free', 'Strength', 'Surface quality'];

export function makeGoalsPanel(app: App, host: HTMLElement, openLoads: () => void): void {
  const sliders = KEYS.map((key, i) => slider({
    label: NAMES[i]!, min: 0, max: 1, step: 0.05, value: 0, show: (value) => value.toFixed(2),
    oninput: (value) => app.setParams({ [key]: value }, key), onchange: () => app.history.seal(),
  }));
  const triangle = makeTriangle((weights, dragging) => {
    app.setParams(Object.fromEntries(KEYS.map((key, i) => [key, weights[i]!])), dragging ? 'triangle' : '');
    if (!dragging) app.history.seal();
  });
  const presets = makePresets(app, GOAL_PRESETS, 'group');
  const detail = makePresets(app, DETAIL_PRESETS, 'grid3', true);
  const hint = h('p', { class: 'note warn', hidden: true });

  function update(): void {
    const weights = KEYS.map((key) => Number(app.param(key) ?? 0)) as Weights;
    sliders.forEach((one, i) => one.set(weights[i]!));
    triangle.set(weights);
    presets.update();
    detail.update();
    const obstacle = app.model ? app.obstacle() : '';
    hint.hidden = !obstacle.startsWith('Strength');
    replace(hint, `${obstacle} `, h('button', { class: 'link', type: 'button', onclick: openLoads }, 'Set loads'));
  }

  replace(host,
    h('section', { class: 'group' }, h('h2', {}, 'What matters'), presets.element, hint),
    h('section', { class: 'group' }, h('h2', {}, 'Balance'), triangle.element, ...sliders.map((one) => one.element),
      h('p', { class: 'small muted' }, '0 switches an objective off. Surface quality and strength may be painted ', h('button', { class: 'link', type: 'button', onclick: openLoads }, 'on some faces'), '; angles and tolerances are under Settings.')),
    h('section', { class: 'group' }, h('h2', {}, 'Detail', h('small', {}, 'tets of the volume mesh')), detail.element));
  app.on('settings', update);
  app.on('model', update);
  update();
}

function makePresets(app: App, presets: Preset[], layout: string, compact = false): { element: HTMLElement; update(): void } {
  const buttons = presets.map((preset) => h('button', {
    class: compact ? 'button' : 'preset', type: 'button', title: preset.help, 'data-preset': preset.name, onclick: () => app.setParams(preset.values),
  }, compact ? preset.name : h('b', {}, preset.name), compact ? null : h('span', {}, preset.help)));
  return {
    element: h('div', { class: layout }, ...buttons),
    update() {
      buttons.forEach((button, i) => button.setAttribute('aria-pressed', String(matchesPreset(presets[i]!, app.settings.params))));
    },
  };
}

/** The triangle is one control: a pointer drags the knob, arrow keys move it. */
function makeTriangle(onchange: (weights: Weights, dragging: boolean) => void): { element: SVGSVGElement; set(weights: Weights): void } {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  const height = Math.sqrt(3) / 2;
  svg.setAttribute('viewBox', `-0.08 -0.1 1.16 ${(height + 0.2).toFixed(3)}`);
  svg.setAttribute('class', 'triangle');
  svg.setAttribute('role', 'application');
  svg.setAttribute('tabindex', '0');
  const path = `M${CORNERS.map((corner) => `${corner.x},${corner.y}`).join('L')}Z`;
  const middle = { x: 0.5, y: (2 / 3) * height };
  svg.innerHTML = `<path class="area" d="${path}"/>${CORNERS.map((corner) => `<line class="net" x1="${corner.x}" y1="${corner.y}" x2="${middle.x}" y2="${middle.y}"/>`).join('')}` +
    `<text x="0.5" y="-0.035" text-anchor="middle">Support free</text><text x="0" y="${height + 0.085}" text-anchor="start">Strength</text>` +
    `<text x="1" y="${height + 0.085}" text-anchor="end">Surface quality</text><circle class="knob" r="0.038"/>`;
  const knob = svg.querySelector('circle')!;
  let at: Weights = [1, 0, 0];

  const pointer = (event: PointerEvent): Weights => {
    const matrix = svg.getScreenCTM()!.inverse();
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix);
    return weightsAt(point);
  };
  svg.addEventListener('pointerdown', (event) => {
    svg.setPointerCapture(event.pointerId);
    onchange(pointer(event), true);
  });
  svg.addEventListener('pointermove', (event) => {
    if (svg.hasPointerCapture(event.pointerId)) onchange(pointer(event), true);
  });
  svg.addEventListener('pointerup', (event) => onchange(pointer(event), false));
  svg.addEventListener('keydown', (event) => {
    const step = ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] } as Record<string, [number, number]>)[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const point = pointOf(at);
    onchange(weightsAt({ x: point.x + 0.07 * step[0], y: point.y + 0.07 * step[1] }), false);
  });
  return {
    element: svg,
    set(weights) {
      at = weights;
      const point = pointOf(weights);
      knob.setAttribute('cx', String(point.x));
      knob.setAttribute('cy', String(point.y));
      svg.setAttribute('aria-label', `Balance of the objectives: ${NAMES.map((name, i) => `${name} ${weights[i]!.toFixed(2)}`).join(', ')}. Arrow keys move it.`);
    },
  };
}

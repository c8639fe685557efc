// Slice, progress, cancel, and the pipeline as a list of stages with state and time.
import type { App } from '../app.ts';
import { h, icon, replace } from '../dom.ts';
import { bytes, seconds } from '../format.ts';
import type { StageInfo } from '../../../wasm/index.js';
import { STAGE_LABELS } from '../stage_labels.ts';

/** Shares of a usual run, for the bar over all stages; measured on the bundled models. */
const WEIGHTS: Record<string, number> = {
  mesh: 2, tetrahedralize: 30, fea: 4, objectives: 0.5, outer_loop: 22, layers: 14, toolpaths: 9, waypoints: 1, motion: 1, export: 1, metrics: 18,
};

export function runFraction(stages: StageInfo[], running: string | null, fraction: number): number {
  let done = 0, total = 0;
  for (const { stage, state } of stages) {
    const weight = WEIGHTS[stage] ?? 1;
    total += weight;
    if (stage === running) done += weight * fraction;
    else if (state === 'done') done += weight;
  }
  return total > 0 ? done / total : 0;
}

const STATE_TEXT: Record<StageInfo['state'], string> = {
  fresh: 'not run yet', running: 'running', done: 'done', stale: 'out of date', failed: 'failed',
};

export function makeRunBar(app: App, host: HTMLElement, saveProgram: () => void): void {
  const go = h('button', { class: 'button primary', type: 'button', id: 'slice', onclick: press });
  const bar = h('div', {});
  const progress = h('div', { class: 'bar', role: 'progressbar', 'aria-label': 'Progress of slicing', 'aria-valuemin': 0, 'aria-valuemax': 100 }, bar);
  const status = h('span', { 'aria-live': 'polite' });
  const list = h('ul', { class: 'stages', 'aria-label': 'Stages', hidden: true });
  const disclosure = h('button', { class: 'disclosure', type: 'button', 'aria-expanded': 'false', onclick: () => {
    list.hidden = !list.hidden;
    disclosure.setAttribute('aria-expanded', String(!list.hidden));
  } }, icon('chevron'), 'Stages');
  let forceTimer: ReturnType<typeof setTimeout> | null = null;
  let force = false;
  replace(host, h('div', { class: 'go' }, go), progress, h('div', { class: 'status' }, status, disclosure), list);

  const isFinished = (): boolean => app.stages.length > 0 && app.stages.every((stage) => stage.state === 'done');
  function press(): void {
    if (!app.running && isFinished()) saveProgram();
    else if (!app.running || app.running.until === 'mesh') void app.slice();
    else if (force) void app.forceStop();
    else app.cancel();
  }

  function update(): void {
    const running = app.running && app.running.until !== 'mesh' ? app.running : null;
    const cancelling = running?.cancelling ?? false;
    if (cancelling && !forceTimer && !force) {
      // A stage without shared memory hears nothing until it is done.
      forceTimer = setTimeout(() => { force = true; update(); }, 2000);
    } else if (!cancelling) {
      if (forceTimer) clearTimeout(forceTimer);
      forceTimer = null;
      force = false;
    }
    const obstacle = app.obstacle();
    const finished = isFinished();
    const partly = app.stages.some((stage) => stage.stage !== 'mesh' && (stage.state === 'stale' || stage.state === 'done'));
    go.textContent = running ? (force ? 'Stop now' : cancelling ? 'Cancelling…' : 'Cancel') : finished ? 'Save the program' : partly ? 'Slice again' : 'Slice';
    go.classList.toggle('primary', !running);
    go.disabled = running ? cancelling && !force : obstacle !== '' && !finished;
    go.title = running ? (force ? 'Ends the engine at once; model and settings stay, results are lost' : 'Esc') : finished ? 'The machine\'s program: G-code' : obstacle || 'Ctrl+Enter';
    tell(obstacle, finished);
    fillList();
  }

  function tell(obstacle: string, finished: boolean): void {
    const { running } = app;
    const fraction = runFraction(app.stages, running?.stage ?? null, running?.fraction ?? 0);
    const shown = running && running.until !== 'mesh' ? fraction : finished ? 1 : 0;
    bar.style.transform = `scaleX(${shown})`;
    progress.setAttribute('aria-valuenow', String(Math.round(100 * shown)));
    if (running) {
      const label = running.stage ? STAGE_LABELS[running.stage] : 'Starting';
      status.textContent = `${label}${running.until === 'mesh' ? '' : ` · ${Math.round(100 * fraction)} %`}`;
    } else if (obstacle && !finished) {
      status.textContent = obstacle;
    } else if (finished) {
      const total = app.stages.reduce((sum, stage) => sum + stage.seconds, 0);
      status.textContent = `${seconds(total)} · ${app.engine?.threads === 1 ? '1 thread' : `${app.engine?.threads} threads`}${app.memoryBytes ? ` · ${bytes(app.memoryBytes)}` : ''}`;
    } else {
      const stale = app.stages.filter((stage) => stage.state === 'stale');
      status.textContent = stale.length > 0 ? `${stale.length} of ${app.stages.length} stages to do again` : 'Ready';
    }
    status.title = status.textContent;  // where it is cut short
  }

  function fillList(): void {
    replace(list, ...app.stages.map((stage) => {
      const state = app.running?.stage === stage.stage ? 'running' : stage.state;
      const time = state === 'running' ? `${Math.round(100 * (app.running?.fraction ?? 0))} %` : stage.state === 'done' ? seconds(stage.seconds) : STATE_TEXT[stage.state];
      return h('li', { class: state, 'data-stage': stage.stage, 'data-state': state },
        h('i', { class: 'dot' }),
        h('span', { class: 'label' }, STAGE_LABELS[stage.stage], stage.warnings.length > 0 && stage.state === 'done' ? h('span', { class: 'muted' }, ` · ${stage.warnings.length} ⚠`) : null),
        h('span', { class: 'time' }, time));
    }));
  }

  for (const event of ['engine', 'model', 'settings', 'stages', 'running'] as const) app.on(event, update);
  app.on('progress', () => { tell(app.obstacle(), false); if (!list.hidden) fillList(); });
  update();
}

// Wires the parts together, nothing else.
import { App } from './app.ts';
import { download, h, icon, iconButton, replace } from './dom.ts';
import { EXAMPLES, MODEL_TYPES } from './examples.ts';
import type { Example } from './examples.ts';
import { makeMessages } from './messages.ts';
import { makeGoalsPanel } from './panels/goals_panel.ts';
import { makeLoadsPanel } from './panels/loads_panel.ts';
import { makeExamples, makeModelPanel } from './panels/model_panel.ts';
import { makeResultsPanel, stem } from './panels/results_panel.ts';
import { makeRunBar } from './panels/run_bar.ts';
import { makeSettingsPanel } from './panels/settings_panel.ts';
import { keepForOffline, registerServiceWorker } from './service_worker_client.ts';
import { makeTabs } from './tabs.ts';
import type { WorkerLike } from './slicer_client.ts';
import { Workspace } from './view/workspace.ts';
import type { ViewName } from './view/workspace.ts';

declare const __ENGINE__: string;

const at = (id: string): HTMLElement => document.getElementById(id)!;

const threads = Number(new URLSearchParams(location.search).get('threads')) || undefined;
const app = new App(
  new URL(__ENGINE__, document.baseURI).href,
  (name) => new Worker(new URL('./slicer_worker.ts', import.meta.url), { type: 'module', name }) as unknown as WorkerLike,
  threads,
);
void app.start();

// --- files

async function openFile(file: File): Promise<void> {
  await app.open({ name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) });
}
async function openExample(example: Example): Promise<void> {
  try {
    const packed = new Blob([await fetched(`examples/${example.file}.gz`)]).stream().pipeThrough(new DecompressionStream('gzip'));
    await app.open({ name: example.file, bytes: new Uint8Array(await new Response(packed).arrayBuffer()) });
    if (!example.job) return;
    const job = JSON.parse(new TextDecoder().decode(await fetched(`examples/${example.job}`))) as { strength: { load_case: string } };
    const name = job.strength.load_case;
    const text = new TextDecoder().decode(await fetched(`examples/${name}`));
    app.change({
      files: { ...app.settings.files, loads: { name, text } },
      params: { ...app.settings.params, 'objectives.support_free': 0.7, 'objectives.strength': 0.3, 'objectives.surface_quality': 0 },
    });
  } catch (error) {
    app.fail(error, `“${example.name}” could not be loaded`);
  }
}
async function fetched(path: string): Promise<Uint8Array<ArrayBuffer>> {
  const response = await fetch(new URL(path, document.baseURI));
  if (!response.ok) throw new Error(`${path}: the server answers ${response.status}.`);
  return new Uint8Array(await response.arrayBuffer());
}

const fileInput = h('input', { type: 'file', accept: MODEL_TYPES, hidden: true, id: 'file-input', 'aria-label': 'Model file', onchange: () => {
  const file = fileInput.files?.[0];
  if (file) void openFile(file);
  fileInput.value = '';
} });
document.body.append(fileInput);
const choose = (): void => fileInput.click();

let dragDepth = 0;
const hasFiles = (event: DragEvent): boolean => event.dataTransfer?.types.includes('Files') ?? false;
const dropping = (on: boolean): void => { at('canvas').parentElement!.classList.toggle('dropping', on); };
window.addEventListener('dragenter', (event) => { if (hasFiles(event)) { ++dragDepth; dropping(true); } });
window.addEventListener('dragleave', (event) => { if (hasFiles(event) && --dragDepth <= 0) { dragDepth = 0; dropping(false); } });
window.addEventListener('dragover', (event) => { if (hasFiles(event)) event.preventDefault(); });
window.addEventListener('drop', (event) => {
  event.preventDefault();
  dragDepth = 0;
  dropping(false);
  const file = event.dataTransfer?.files[0];
  if (file) void openFile(file);
});

async function saveProject(): Promise<void> {
  try {
    download(`${stem(app)}.s3.zip`, (await app.project()) as Uint8Array<ArrayBuffer>, 'application/zip');
  } catch (error) {
    app.fail(error, 'The project could not be saved');
  }
}

// --- panels and view

// Panels are made first; what they say before there is a view goes nowhere.
let workspace: Workspace | null = null as Workspace | null;
const tabs = makeTabs(at('tabs'), at('panels'), [['part', 'Part'], ['goals', 'Goals'], ['loads', 'Loads'], ['settings', 'Settings'], ['results', 'Results']], () => workspace?.loadsChanged());
const loads = makeLoadsPanel(app, tabs.panel('loads'), () => tabs.current() === 'loads' && app.model !== null, () => workspace?.loadsChanged());
const view = (workspace = new Workspace(app, loads, {
  canvas: at('canvas'), views: at('views'), display: at('display'), legend: at('legend'), info: at('info'), timeline: at('timeline'), marks: at('marks'),
}));
const modelPanel = makeModelPanel(app, tabs.panel('part'), EXAMPLES, {
  choose,
  example: (example) => void openExample(example),
  setLaying: (on) => view.setLaying(on ? () => modelPanel.stopLaying() : null),
  mark: (places) => view.mark(places, 'file'),
});
makeGoalsPanel(app, tabs.panel('goals'), () => tabs.choose('loads'));
makeSettingsPanel(app, tabs.panel('settings'));
const results = makeResultsPanel(app, tabs.panel('results'), {
  async picture() {
    download(`${stem(app)}-${view.view}.png`, await view.viewer.picture(), 'image/png');
  },
  saveProject,
  mark: (places) => view.mark(places, 'rest'),
});
makeRunBar(app, at('runbar'), () => void results.saveProgram());
makeMessages(app, at('messages'), (places, frame) => view.mark(places, frame));
let evaluated = false;
app.on('done', (stage) => { evaluated ||= stage === 'metrics'; });
app.on('running', () => {
  if (app.running || !evaluated) return;
  evaluated = false;
  // First filled, then shown: nothing moves under the eyes.
  void results.complete().then(() => tabs.choose('results'));
});

replace(at('welcome'), h('div', { class: 'card' },
  h('h2', {}, 'Curved layers for any solid'),
  h('div', { class: 'drop' }, icon('cube'), h('p', {}, 'Drop a model here'),
    h('button', { class: 'button primary', type: 'button', onclick: choose }, 'Choose a file…'),
    h('p', { class: 'small muted' }, 'STL, OBJ, PLY, 3MF, OFF, TET, MSH, VTU, or a project. Nothing leaves this computer.')),
  h('div', { class: 'group' }, h('p', { class: 'muted' }, 'or take an example'), makeExamples(EXAMPLES, (example) => void openExample(example)))));
app.on('model', () => {
  at('welcome').hidden = app.model !== null;
  replace(at('file'), app.model && h('b', {}, app.model.file.name));
});

// --- top bar, theme, keys

const undo = iconButton('undo', 'Undo (Ctrl+Z)', () => app.undo());
const redo = iconButton('redo', 'Redo (Ctrl+Shift+Z)', () => app.redo());
const theme = iconButton('moon', 'Dark or light', () => setTheme(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark'));
const help = h('dialog', { 'aria-label': 'Keys' }, h('h2', {}, 'Keys'), h('dl', { class: 'facts' }, ...[
  ['Slice', 'Ctrl Enter'], ['Cancel', 'Esc'], ['Undo, redo', 'Ctrl Z, Ctrl Shift Z'], ['Open, save project', 'Ctrl O, Ctrl S'], ['Views', '1 … 7'], ['One layer up, down', '↑ ↓'], ['Print, pause', 'Space'], ['Whole part', 'F'],
].flatMap(([what, keys]) => [h('dt', {}, what!), h('dd', {}, h('kbd', {}, keys!))])), h('form', { method: 'dialog', class: 'row', style: 'margin-top: 14px; justify-content: flex-end' }, h('button', { class: 'button' }, 'Close')));
document.body.append(help);
replace(at('tools'), undo, redo, iconButton('open', 'Open (Ctrl+O)', choose), iconButton('save', 'Save the project (Ctrl+S)', () => void saveProject()),
  iconButton('fit', 'Show the whole part (F)', () => view.look('iso')), theme, iconButton('help', 'Keys', () => help.showModal()));

function setTheme(name: string): void {
  document.documentElement.dataset.theme = name;
  localStorage.setItem('theme', name);
  replace(theme, icon(name === 'dark' ? 'sun' : 'moon'));
  view.viewer.applyTheme();
}
setTheme(document.documentElement.dataset.theme ?? 'light');
app.on('settings', () => {
  undo.disabled = !app.history.canUndo;
  redo.disabled = !app.history.canRedo;
});
undo.disabled = redo.disabled = true;

const ORDER: ViewName[] = ['model', 'mesh', 'stress', 'shape', 'field', 'layers', 'paths'];
window.addEventListener('keydown', (event) => {
  const target = event.target as HTMLElement;
  const typing = target.matches('input:not([type=range]):not([type=checkbox]), textarea, select');
  const control = event.ctrlKey || event.metaKey;
  const key = event.key.toLowerCase();
  const act = (action: () => void): void => { event.preventDefault(); action(); };
  if (control && key === 'enter') act(() => void app.slice());
  else if (control && key === 'o') act(choose);
  else if (control && key === 's') act(() => void saveProject());
  else if (typing) return;
  else if (control && key === 'z') act(() => (event.shiftKey ? app.redo() : app.undo()));
  else if (control && key === 'y') act(() => app.redo());
  else if (control || event.altKey || help.open) return;
  else if (key === 'escape' && app.running) act(() => app.cancel());
  else if (key === 'f') act(() => view.look('iso'));
  else if (key === ' ' && !target.matches('button')) act(() => view.togglePlay());
  else if ((key === 'arrowup' || key === 'arrowdown') && !target.matches('input, button, [role=application]')) act(() => view.step(key === 'arrowup' ? 1 : -1));
  else if (/^[1-7]$/.test(key)) {
    const name = ORDER[Number(key) - 1]!;
    if (view.showNext().includes(name)) act(() => void view.show(name));
  }
});

registerServiceWorker(() => app.model === null);
app.on('engine', () => {
  const threaded = app.engine !== null && app.engine.threads > 1;
  const files = threaded ? ['s3slicer-threads.mjs', 's3slicer-threads.wasm', 's3slicer-threads.worker.js'] : ['s3slicer.mjs', 's3slicer.wasm'];
  keepForOffline(files.map((name) => new URL(__ENGINE__ + name, document.baseURI).href));
});
// For measurements in the browser tests: frame times and draw calls.
Object.assign(window, { s3: { app, workspace: view } });

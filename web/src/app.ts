// The state of the page and what may be done with it. Knows neither elements nor three.js; the parts listen to it.
import type { ExportInfo, FileSurface, Inspection, Progress, Stage, StageInfo, Warning, Which } from '../../wasm/index.js';
import { History } from './history.ts';
import { NO_LOADS, hasLoads, loadProblems, loadsFrom } from './load_case.ts';
import type { Loads } from './load_case.ts';
import type { EngineInfo, Job, LoadFileKind, ModelFile, ResultName, Results, TextFile } from './protocol.ts';
import { parseRotation, placementAngles, previewPlacement } from './rotation.ts';
import type { Vec } from './rotation.ts';
import { DETAIL_PRESETS, defaultsOf, schemaFields } from './settings.ts';
import type { ParamField, ParamValues } from './settings.ts';
import { SliceError, SlicerClient } from './slicer_client.ts';
import type { WorkerLike } from './slicer_client.ts';

/** What undo and redo go through, and what a project keeps beside the model. */
export interface Settings {
  params: ParamValues;
  loads: Loads;
  /** Files that take the place of what the editor makes. */
  files: Record<LoadFileKind, TextFile | null>;
  stress: ModelFile | null;
  profile: { name: string; json: string } | null;
}

const NO_FILES: Settings['files'] = { loads: null, surface: null, critical: null };

export interface Model {
  file: ModelFile;
  /** As the file gives it, in its own frame. */
  surface: FileSurface;
}

/** Which stage a result is of. */
export const RESULT_STAGE: Record<ResultName, Stage> = {
  placement: 'mesh', surface: 'mesh', tets: 'tetrahedralize', stress: 'fea', faces: 'objectives', deformation: 'outer_loop',
  faceAngles: 'outer_loop', histogramData: 'layers', gouging: 'outer_loop', layers: 'layers', waypoints: 'waypoints',
  motion: 'motion', metrics: 'metrics', plots: 'metrics',
};

export interface Problem {
  title: string;
  message: string;
  hint: string;
  places: [number, number, number][];
  /** Frame of the places. */
  frame: 'file' | 'rest';
}

export interface Events {
  engine: void;
  model: void;
  placement: void;
  inspection: void;
  settings: void;
  stages: void;
  running: void;
  progress: Progress;
  /** A stage has (new) results. */
  done: Stage;
  problem: Problem;
}
type Listener<Name extends keyof Events> = (payload: Events[Name]) => void;

export interface Running {
  until: Stage;
  stage: Stage | null;
  fraction: number;
  cancelling: boolean;
  began: number;
}

export class App {
  engine: EngineInfo | null = null;
  fields: ParamField[] = [];
  model: Model | null = null;
  inspection: Inspection | null = null;
  /** From the file's frame to the rest frame, 4×4 column by column: the slicer's, or what it will be. */
  placement: Float64Array = new Float64Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
  stages: StageInfo[] = [];
  running: Running | null = null;
  memoryBytes = 0;
  readonly history = new History<Settings>({ params: {}, loads: NO_LOADS, files: NO_FILES, stress: null, profile: null });
  readonly client: SlicerClient;
  #engineUrl: string;
  #listeners = new Map<keyof Events, Set<Listener<never>>>();
  #results = new Map<string, { version: number; value: Promise<unknown> }>();
  #versions = new Map<Stage, number>();
  #crashes: number[] = [];
  #jobTimer: ReturnType<typeof setTimeout> | null = null;
  #queue: Promise<unknown> = Promise.resolve();
  #epoch = 0;
  #starting = false;
  #threads: number | undefined;

  constructor(engineUrl: string, makeWorker: (name: string) => WorkerLike, threads?: number) {
    this.#engineUrl = engineUrl;
    this.#threads = threads;
    this.client = new SlicerClient(makeWorker, {
      onProgress: (progress, memory) => this.#onProgress(progress, memory),
      onStages: (stages) => this.#onStages(stages),
      onCrash: (error) => void this.#onCrash(error),
    });
  }

  on<Name extends keyof Events>(name: Name, listener: Listener<Name>): void {
    if (!this.#listeners.has(name)) this.#listeners.set(name, new Set());
    this.#listeners.get(name)!.add(listener as Listener<never>);
  }
  #emit<Name extends keyof Events>(name: Name, ...[payload]: Events[Name] extends void ? [] : [Events[Name]]): void {
    for (const listener of this.#listeners.get(name) ?? []) (listener as (payload: unknown) => void)(payload);
  }

  get settings(): Settings {
    return this.history.present;
  }
  param<Value extends string | number | boolean>(key: string): Value {
    return this.settings.params[key] as Value;
  }

  /** Degrees about x, y, z that the part is turned by now, also where the slicer chose them. */
  rotation(): Vec {
    return parseRotation(String(this.param('input.rotate') ?? '0,0,0')) ?? placementAngles(this.placement, String(this.param('input.up') ?? 'z'));
  }

  /** Loads the engine. Settings that are there already stay. */
  async start(): Promise<void> {
    this.#starting = true;
    try {
      this.engine = await this.client.start({ engineUrl: this.#engineUrl, ...(this.#threads ? { threads: this.#threads } : {}) });
      this.fields = schemaFields(this.engine.schema);
      if (Object.keys(this.settings.params).length === 0) {
        const params = { ...defaultsOf(this.fields), ...DETAIL_PRESETS[1]!.values };
        this.history.reset({ ...this.settings, params });
      }
      this.#emit('engine');
      this.#emit('settings');
    } catch (error) {
      this.fail(error, 'The slicing engine could not be loaded');
    }
    this.#starting = false;
    this.#emit('running');
  }

  // --- model

  /** Takes a model file or a project. */
  async open(file: ModelFile): Promise<void> {
    await this.#stopRun();
    if (!this.engine) await this.start();
    if (!this.engine) return;
    if (/\.zip$/i.test(file.name)) return this.#openProject(file);
    const epoch = ++this.#epoch;
    try {
      const surface = await this.client.call('setModel', file);
      if (epoch !== this.#epoch) return;
      const { params } = this.settings;
      this.history.reset({
        ...this.settings,
        params: { ...params, 'input.rotate': '0,0,0' },
        loads: NO_LOADS, files: NO_FILES, stress: null,
      });
      this.#newModel({ file, surface });
      await this.#prepare(epoch);
    } catch (error) {
      if (epoch === this.#epoch) this.fail(error, `“${file.name}” could not be opened`);
    }
  }

  /** Settings, loads and model as saveProject() wrote them; also projects that other programs of S³ Slicer wrote. */
  async #openProject(file: ModelFile): Promise<void> {
    const epoch = ++this.#epoch;
    try {
      const opened = await this.client.call('openProject', file.bytes);
      const extra = opened.extra as Partial<ProjectExtra> | null;
      this.history.reset({
        params: { ...defaultsOf(this.fields), ...opened.params },
        loads: loadsFrom(extra?.loads) ?? NO_LOADS,
        files: extra?.files ?? (extra?.loads?.regions.length ? NO_FILES : opened.files),
        stress: opened.stress,
        profile: extra?.profile ?? null,
      });
      this.#newModel({ file: opened.model, surface: opened.surface });
      await this.#prepare(epoch);
    } catch (error) {
      this.fail(error, `“${file.name}” could not be opened`);
    }
  }

  #newModel(model: Model): void {
    this.model = model;
    this.inspection = null;
    this.#results.clear();
    this.#versions.clear();
    this.stages = [];
    this.#preview();
    this.#emit('model');
    this.#emit('settings');
  }

  /** Settings to the slicer, the surface repaired and placed, the report on the file. */
  async #prepare(epoch: number): Promise<void> {
    await this.sendJob();
    await this.run('mesh');
    if (epoch !== this.#epoch) return;
    try {
      const inspection = await this.client.call('inspect');
      if (epoch !== this.#epoch) return;
      this.inspection = inspection;
      this.#emit('inspection');
    } catch (error) {
      if (!(error instanceof SliceError && error.kind !== 'input')) return;  // the stage `mesh` has said it already
      if (epoch === this.#epoch) this.fail(error, 'The file could not be inspected');
    }
  }

  /** Where the part will stand, as far as that is known before the stage `mesh`. */
  #preview(): void {
    if (!this.model) return;
    const rotation = this.rotation();
    this.placement = previewPlacement(this.model.surface.positions, String(this.param('input.up') ?? 'z'), Number(this.param('input.scale') ?? 1), rotation);
    this.#emit('placement');
  }

  // --- settings

  /** @param step changes with the same step name, one after the other, are undone together */
  change(next: Partial<Settings>, step = ''): void {
    this.history.push({ ...this.settings, ...next }, step);
    this.#settingsChanged();
  }
  setParams(values: ParamValues, step = ''): void {
    const params = { ...this.settings.params, ...values };
    if (Object.keys(values).every((key) => this.settings.params[key] === values[key])) return;
    this.change({ params }, step);
  }
  undo(): void {
    if (!this.history.canUndo) return;
    this.history.undo();
    this.#settingsChanged();
  }
  redo(): void {
    if (!this.history.canRedo) return;
    this.history.redo();
    this.#settingsChanged();
  }

  #settingsChanged(): void {
    const mesh = this.stages.find((stage) => stage.stage === 'mesh');
    this.#emit('settings');
    if (!this.model || !this.engine) return;
    const before = this.#sentInput;
    if (before !== this.#inputKey()) this.#preview();
    if (this.#jobTimer) clearTimeout(this.#jobTimer);
    this.#jobTimer = setTimeout(() => {
      this.#jobTimer = null;
      if (this.running && this.running.until !== 'mesh') return;  // sent when the run ends
      void this.#settle(mesh !== undefined);
    }, 250);
  }

  /** Sends the settings and, where the part has to be placed anew, places it. */
  async #settle(known: boolean): Promise<void> {
    try {
      await this.sendJob();
      const mesh = this.stages.find((stage) => stage.stage === 'mesh');
      if (known && mesh && mesh.state !== 'done' && !this.running) await this.run('mesh');
    } catch (error) {
      this.fail(error, 'These settings cannot be used');
    }
  }

  #sentInput = '';
  #inputKey(): string {
    const { params } = this.settings;
    return ['input.up', 'input.scale', 'input.rotate', 'input.sheet_thickness'].map((key) => String(params[key])).join(' ');
  }

  job(): Job {
    const { params, loads, files, stress, profile } = this.settings;
    const loadsComplete = hasLoads(loads) && loadProblems(loads).length === 0;
    const texts = { loads: files.loads?.text ?? null, surface: files.surface?.text ?? null, critical: files.critical?.text ?? null };
    return { params, loads, loadsComplete, files: texts, stress, profile };
  }

  async sendJob(): Promise<void> {
    this.#sentInput = this.#inputKey();
    this.#onStages(await this.client.call('setJob', this.job()));
  }

  // --- running

  /** What stands against slicing, for people; empty when nothing does. */
  obstacle(): string {
    if (!this.engine) return this.#starting ? 'The slicing engine is loading' : 'The slicing engine does not run; open a file to start it again';
    if (!this.model) return 'Open a model first';
    if (Number(this.param('objectives.strength')) > 0 && !this.settings.stress && !this.settings.files.loads) {
      const problems = loadProblems(this.settings.loads);
      if (problems.length > 0) return `Strength needs loads. ${problems[0]}`;
    }
    return '';
  }

  /** Everything that is not done. */
  async slice(): Promise<void> {
    if (this.running && this.running.until !== 'mesh') return;
    await this.#queue;  // the part may still be on its way to the plate
    if (this.running || this.obstacle()) return;
    try {
      await this.sendJob();
    } catch (error) {
      this.fail(error, 'These settings cannot be used');
      return;
    }
    await this.run('metrics');
  }

  async run(until: Stage): Promise<void> {
    await this.#queue;
    const work = this.#run(until);
    this.#queue = work;
    await work;
  }

  async #run(until: Stage): Promise<void> {
    this.running = { until, stage: null, fraction: 0, cancelling: false, began: performance.now() };
    this.#emit('running');
    try {
      this.#onStages(await this.client.call('run', { until }));
    } catch (error) {
      if (!(error instanceof SliceError && error.kind === 'cancelled')) this.fail(error, 'Slicing stopped');
    }
    this.running = null;
    this.#emit('running');
    if (this.#jobTimer === null && this.engine && this.model) {
      // Settings that were changed during the run.
      try {
        await this.sendJob();
      } catch (error) {
        this.fail(error, 'These settings cannot be used');
      }
    }
  }

  cancel(): void {
    if (!this.running) return;
    this.running.cancelling = true;
    this.client.cancel();
    this.#emit('running');
  }

  /** Ends the worker where a cancel is not heard soon enough. Results are lost, model and settings stay. */
  async forceStop(): Promise<void> {
    this.client.stop();
    this.running = null;
    this.engine = null;
    this.#emit('running');
    await this.#restore();
  }

  async #stopRun(): Promise<void> {
    if (!this.running) return;
    this.cancel();
    await this.#queue;
  }

  #onProgress(progress: Progress, memoryBytes: number): void {
    this.memoryBytes = memoryBytes;
    const step = progress.stage;
    const stage = this.stages.some((one) => one.stage === step) ? (step as Stage) : 'outer_loop';
    if (this.running) Object.assign(this.running, { stage, fraction: overallFraction(step, progress.fraction) });
    this.#emit('progress', progress);
  }

  #onStages(stages: StageInfo[]): void {
    const before = new Map(this.stages.map((stage) => [stage.stage, stage.state]));
    this.stages = stages;
    for (const stage of stages) {
      if (stage.state !== 'done' || before.get(stage.stage) === 'done') continue;
      this.#versions.set(stage.stage, (this.#versions.get(stage.stage) ?? 0) + 1);
      if (stage.stage === 'mesh') void this.#takePlacement();
      this.#emit('done', stage.stage);
    }
    this.#emit('stages');
  }

  async #takePlacement(): Promise<void> {
    const placement = await this.result('placement');
    if (!placement) return;
    this.placement = placement;
    this.#emit('placement');
  }

  async #onCrash(error: SliceError): Promise<void> {
    this.engine = null;
    this.running = null;
    this.#emit('running');
    this.#problem('The slicing engine had to be started again', error.message, error.hint);
    const now = performance.now();
    this.#crashes = this.#crashes.filter((time) => now - time < 30000);
    this.#crashes.push(now);
    if (this.#crashes.length <= 2) await this.#restore();
  }

  /** A new engine with the same model and settings. */
  async #restore(): Promise<void> {
    const epoch = ++this.#epoch;
    this.stages = [];
    await this.start();
    if (!this.engine || !this.model || epoch !== this.#epoch) return;
    try {
      await this.client.call('setModel', this.model.file);
      await this.sendJob();
      await this.run('mesh');
    } catch (error) {
      this.fail(error, 'The model could not be given to the new engine');
    }
  }

  // --- results

  /** A result as it was when its stage ran last; null before that. Fetched once. */
  result<Name extends ResultName>(name: Name, which?: Which): Promise<Results[Name] | null> {
    const key = which ? `${name}/${which}` : name;
    const stage = which === 'planar' ? 'metrics' : RESULT_STAGE[name];
    const version = this.#versions.get(stage) ?? 0;
    const known = this.#results.get(key);
    if (known?.version === version) return known.value as Promise<Results[Name] | null>;
    if (version === 0) return Promise.resolve(null);
    const value = this.client.result(name, which).catch(() => null);
    const entry = { version, value: value as Promise<unknown> };
    this.#results.set(key, entry);
    // A stage that became stale meanwhile has no result: the former one is better than none.
    void value.then((found) => {
      if (found === null && known) this.#results.set(key, known);
    });
    return value;
  }

  /** Whether a stage has run for this model, be it with other settings. */
  has(stage: Stage): boolean {
    return (this.#versions.get(stage) ?? 0) > 0;
  }
  isStale(stage: Stage): boolean {
    return this.has(stage) && this.stages.find((one) => one.stage === stage)?.state !== 'done';
  }
  warnings(): { stage: StageInfo; warning: Warning }[] {
    return this.stages.filter((stage) => stage.state === 'done').flatMap((stage) => stage.warnings.map((warning) => ({ stage, warning })));
  }

  exports(): Promise<ExportInfo[]> {
    return this.client.call('listExports');
  }
  exportFile(name: string): Promise<Uint8Array> {
    return this.client.call('exportFile', name);
  }

  async project(): Promise<Uint8Array> {
    if (!this.model) throw new Error('There is no model to save.');
    const { loads, files, profile } = this.settings;
    const extra: ProjectExtra = { loads, files, profile };
    await this.sendJob();
    return this.client.call('saveProject', extra);
  }

  // --- telling

  fail(error: unknown, title: string): void {
    if (error instanceof SliceError) {
      if (error.kind === 'cancelled' || error.code === 'engine.crashed') return;  // #onCrash() says it once
      this.#problem(title, error.message, error.hint, error.places, error.stage === 'mesh' ? 'file' : 'rest');
    } else {
      this.#problem(title, error instanceof Error ? error.message : String(error), '');
    }
  }
  #problem(title: string, message: string, hint: string, places: [number, number, number][] = [], frame: 'file' | 'rest' = 'rest'): void {
    this.#emit('problem', { title, message, hint, places, frame });
  }
}

/** What the page keeps in a project beside what the slicer has in it. */
interface ProjectExtra {
  loads: Loads;
  files: Settings['files'];
  profile: Settings['profile'];
}

/** Share of `outer_loop` before and after each of its steps: the refinement of the field takes most of it. */
const STEP_RANGE: Record<string, [number, number]> = {
  quaternion_field: [0, 0.15], deformation: [0.15, 0.15], scalar_field: [0.15, 1],
};

export function overallFraction(step: string, fraction: number): number {
  const range = STEP_RANGE[step];
  return range ? range[0] + (range[1] - range[0]) * fraction : fraction;
}

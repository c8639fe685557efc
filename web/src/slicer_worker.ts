// Owns the WASM engine. Computes one unit at a time and listens for messages in between, so that a cancel is heard
// even where threads cannot share memory.
import { load, SlicerError } from '../../wasm/index.js';
import type { Engine, InputFile, Progress, Slicer, Stage } from '../../wasm/index.js';
import { loadCaseJson, regionJson } from './load_case.ts';
import { aliveLock, transferables } from './protocol.ts';
import type { CallName, Calls, EngineInfo, FromWorker, Job, LoadFileKind, ModelFile, OpenedProject, TextFile, ToWorker } from './protocol.ts';
import { flattenParams } from './settings.ts';

let engine: Engine | null = null;
let slicer: Slicer | null = null;
let job: Job | null = null;
let given: Record<LoadFileKind, string> = { loads: '', surface: '', critical: '' };  // what the slicer got last
let givenStress: ModelFile | null = null;
let givenProfile = '';
let cancelled = false;

const scope = self as unknown as DedicatedWorkerGlobalScope;
const post = (message: FromWorker, transfer: ArrayBuffer[] = []): void => scope.postMessage(message, transfer);

/** Lets waiting messages in. */
const breathe = (): Promise<void> =>
  new Promise((resolve) => {
    const channel = new MessageChannel();
    channel.port1.onmessage = () => {
      channel.port1.close();
      resolve();
    };
    channel.port2.postMessage(null);
  });

function running(): Slicer {
  if (!slicer) throw usage('The engine has not been started');
  return slicer;
}

function usage(message: string): SlicerError {
  return new SlicerError({ kind: 'engine', code: 'engine.usage', stage: null, message, hint: '', places: [] });
}

async function start(options: { engineUrl: string; threads?: number }): Promise<EngineInfo> {
  engine = await load({ baseUrl: options.engineUrl, ...(options.threads ? { threads: options.threads } : {}) });
  slicer = engine.createSlicer();
  const started = engine;
  return {
    version: started.version,
    threads: started.threads,
    schema: started.schema(),
    machines: started.machines().map((name) => started.machineProfile(name)),
    cancelFlag: slicer.cancelFlag,
  };
}

function setModel(model: ModelFile) {
  running().setModel(model.bytes, model.name);
  return running().fileSurface();
}

function setJob(next: Job) {
  const target = running();
  if (next.profile && next.profile.json !== givenProfile) {
    target.setMachineProfile(next.profile.name, next.profile.json);
    givenProfile = next.profile.json;
  }
  target.setParams(next.params);
  if (next.stress !== givenStress) {
    target.setStress(next.stress?.bytes ?? null, next.stress?.name);
    givenStress = next.stress;
  }
  job = next;
  applyLoads();
  return target.stages();
}

/** Regions are kept in the file's frame; the core wants them where the part stands, known after the stage `mesh`. */
function applyLoads(): void {
  if (!job) return;
  const target = running(), { loads, loadsComplete, files } = job;
  const placement = target.placement();
  const apply = (kind: LoadFileKind, made: (at: Float64Array) => string, set: (text: string | null) => void): void => {
    const text = files[kind] ?? (placement ? made(placement) : null);
    if (text === null || text === given[kind]) return;
    set(text === '' ? null : text);
    given[kind] = text;
  };
  apply('loads', (at) => (loadsComplete ? loadCaseJson(loads, at) : ''), (text) => target.setLoadCase(text, 'loads.json'));
  apply('surface', (at) => regionJson(loads, 'surface', at), (text) => target.setSurfaceRegion(text, 'surface.json'));
  apply('critical', (at) => regionJson(loads, 'critical', at), (text) => target.setCriticalRegion(text, 'critical.json'));
}

function report(progress: Progress): void {
  post({ type: 'progress', progress, memoryBytes: engine?.memoryBytes ?? 0 });
}

async function run({ until }: { until: Stage }) {
  const target = running();
  cancelled = false;
  target.clearCancel();
  const order = target.stages().map((stage) => stage.stage);
  const last = order.indexOf(until);
  for (;;) {
    const next = target.stages().find((stage) => stage.state !== 'done');
    if (!next || order.indexOf(next.stage) > last) return target.stages();
    await breathe();
    if (cancelled) {
      throw new SlicerError({
        kind: 'cancelled', code: 'cancelled', stage: next.stage, message: 'Cancelled', hint: '', places: [],
      });
    }
    try {
      report({ stage: next.stage, fraction: 0 });
      target.advance(report);
      if (next.stage === 'mesh') applyLoads();
    } finally {
      if (engine && !engine.crashed) post({ type: 'stages', stages: target.stages() });
    }
  }
}

function result({ name, which }: Parameters<Calls['result']>[0]) {
  const target = running();
  switch (name) {
    case 'placement': return target.placement();
    case 'surface': return target.surface();
    case 'tets': return target.tets();
    case 'stress': return target.stress();
    case 'faces': return target.faces();
    case 'deformation': return target.deformation();
    case 'faceAngles': return target.faceAngles(which ? { which } : {});
    case 'histogramData': return target.histogramData(which ? { which } : {});
    case 'gouging': return target.gouging();
    case 'layers': return target.layers(which ? { which } : {});
    case 'waypoints': return target.waypoints(which ? { which } : {});
    case 'motion': return target.motion();
    case 'metrics': return target.metrics();
    case 'plots': return target.plots();
  }
}

function openProject(bytes: Uint8Array<ArrayBuffer>): OpenedProject {
  const target = running();
  const extra = target.openProject(bytes);
  const { model, loadCase, surfaceRegion, criticalRegion, stress } = target.inputFiles();
  if (!model) throw usage('The project holds no model');
  given = { loads: '\0', surface: '\0', critical: '\0' };  // whatever the project held
  const text = (file: InputFile | null): TextFile | null => file && { name: file.name, text: new TextDecoder().decode(file.bytes) };
  const files = { loads: text(loadCase), surface: text(surfaceRegion), critical: text(criticalRegion) };
  return { extra, model: model as ModelFile, surface: target.fileSurface(), params: flattenParams(target.givenParams()), files, stress: stress as ModelFile | null };
}

const calls: { [Name in CallName]: (argument: never) => unknown } = {
  start,
  setModel,
  inspect: () => running().inspect(),
  setJob,
  run,
  result,
  report: () => running().report(),
  listExports: () => running().listExports(),
  exportFile: (name: string) => running().exportFile(name),
  saveProject: (extra: unknown) => running().saveProject(extra),
  openProject,
};

function describe(error: unknown): SlicerError {
  if (error instanceof SlicerError) return error;
  const message = error instanceof Error ? error.message : String(error);
  return new SlicerError({
    kind: 'engine', code: 'engine.crashed', stage: null, message, hint: 'The engine is started again; model and settings stay.', places: [],
  });
}

async function answer(id: number, name: CallName, argument: unknown): Promise<void> {
  try {
    const value = await calls[name](argument as never);
    post({ type: 'answer', id, value }, transferables(value));
  } catch (error) {
    post({ type: 'failure', id, error: describe(error).toJSON() });
  }
}

scope.onmessage = (event: MessageEvent<ToWorker>) => {
  const message = event.data;
  if (message.type === 'cancel') {
    cancelled = true;
  } else {
    void answer(message.id, message.name, message.argument);
  }
};

// The page waits for this lock: it gets it when this worker is gone, however that came about.
void navigator.locks?.request(aliveLock(scope.name), () => new Promise(() => {}));

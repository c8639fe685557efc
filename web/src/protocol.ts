// Every message between the page and the worker that slices, with its answer.
import type {
  DeformationArrays, ExportInfo, FaceAngles, FaceArrays, FileSurface, Gouging, HistogramData, Inspection, JsonSchema, LayerArrays,
  MachineProfile, Metrics, MotionArrays, Progress, Report, SlicerErrorFields, Stage, StageInfo, StressArrays, Surface,
  TetArrays, WaypointArrays, Which,
} from '../../wasm/index.js';
import type { Loads, PaintKind } from './load_case.ts';
import type { ParamValues } from './settings.ts';

export interface ModelFile {
  name: string;
  bytes: Uint8Array<ArrayBuffer>;
}

/** What the editor makes, or a file gives instead. */
export type LoadFileKind = 'loads' | PaintKind;
export interface TextFile {
  name: string;
  text: string;
}

export interface EngineInfo {
  version: string;
  threads: number;
  schema: JsonSchema;
  machines: MachineProfile[];
  /** Set its first byte to 1 to cancel the running unit; null where memory cannot be shared. */
  cancelFlag: Uint8Array | null;
}

/** All that a run depends on beside the model. */
export interface Job {
  /** Every parameter of the form by its dotted key, defaults included. */
  params: ParamValues;
  /** Regions in the file's frame, so that they follow the part when it is turned. */
  loads: Loads;
  /** Loads that are still being made would be refused: they are left out. */
  loadsComplete: boolean;
  /** A load case and region files as written by hand or by another program: taken as they are, in the rest frame. */
  files: Record<LoadFileKind, string | null>;
  /** Stress of every tet of a volume file. */
  stress: ModelFile | null;
  /** A machine profile of one's own, selected by params.machine. */
  profile: { name: string; json: string } | null;
}

/** Results by name, as the API gives them; null while their stage is not done. */
export interface Results {
  placement: Float64Array;
  surface: Surface;
  tets: TetArrays;
  stress: StressArrays;
  faces: FaceArrays;
  deformation: DeformationArrays;
  faceAngles: FaceAngles;
  histogramData: HistogramData;
  gouging: Gouging;
  layers: LayerArrays;
  waypoints: WaypointArrays;
  motion: MotionArrays;
  metrics: { curved: Metrics; planar: Metrics };
  plots: { name: string; svg: string }[];
}
export type ResultName = keyof Results;

/** What the page may ask of the worker. Each call has one answer: a value or an error. */
export interface Calls {
  start(options: { engineUrl: string; threads?: number }): EngineInfo;
  setModel(model: ModelFile): FileSurface;
  inspect(): Inspection;
  setJob(job: Job): StageInfo[];
  /** Runs what is not done, up to and including the stage. Progress and finished stages arrive as events. */
  run(options: { until: Stage }): StageInfo[];
  result(options: { name: ResultName; which?: Which }): Results[ResultName] | null;
  report(): Report;
  listExports(): ExportInfo[];
  exportFile(name: string): Uint8Array;
  saveProject(extra: unknown): Uint8Array;
  /** Takes model and settings from a project; the answer is what was given as `extra`. */
  openProject(bytes: Uint8Array<ArrayBuffer>): OpenedProject;
}
export type CallName = keyof Calls;

export interface OpenedProject {
  /** What saveProject() was given; null in projects of others. */
  extra: unknown;
  model: ModelFile;
  surface: FileSurface;
  params: ParamValues;
  files: Record<LoadFileKind, TextFile | null>;
  stress: ModelFile | null;
}

export type ToWorker =
  | { type: 'call'; id: number; name: CallName; argument: unknown }
  /** Stops a run before its next unit; the running unit too where memory is shared. */
  | { type: 'cancel' };

export type FromWorker =
  | { type: 'answer'; id: number; value: unknown }
  | { type: 'failure'; id: number; error: SlicerErrorFields }
  | { type: 'progress'; progress: Progress; memoryBytes: number }
  | { type: 'stages'; stages: StageInfo[] };

/** The name of the lock that a worker holds while it lives. */
export const aliveLock = (id: string): string => `s3slicer-worker-${id}`;

/** The buffers behind a value, to be handed over rather than copied. Buffers that are shared between threads stay. */
export function transferables(value: unknown): ArrayBuffer[] {
  const found = new Set<ArrayBuffer>();
  const visit = (item: unknown): void => {
    if (ArrayBuffer.isView(item)) {
      if (item.buffer instanceof ArrayBuffer) found.add(item.buffer);
    } else if (Array.isArray(item)) {
      if (item.length > 0 && typeof item[0] === 'object') item.forEach(visit);
    } else if (item !== null && typeof item === 'object') {
      Object.values(item).forEach(visit);
    }
  };
  visit(value);
  return [...found];
}

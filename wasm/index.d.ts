/**
 * S³ Slicer as WebAssembly: curved layers for multi-axis 3D printing, in a browser or in Node.
 *
 * ```js
 * import { load } from 's3slicer';
 * const engine = await load();
 * const slicer = engine.createSlicer();
 * slicer.setModel(bytes, 'part.stl');
 * slicer.setParams({ 'mesh.target_tets': 20000 });
 * await slicer.run();
 * const program = slicer.exportFile('program.gcode');
 * ```
 *
 * Units everywhere: mm, N, MPa, s; angles in degrees where a name says so; right-handed, z up, plate at z = 0.
 * Quaternions are x y z w. All calls compute on the calling thread: in a page, use it from a worker.
 *
 * Arrays are fresh copies: they stay valid whatever happens to the slicer, and their buffers may be transferred.
 * Reals come as Float32Array (what a GPU takes), or as Float64Array where a method is asked for `{ precision: 64 }`.
 */

/** The stages in the order in which they run. */
export type Stage =
  | 'mesh'
  | 'tetrahedralize'
  | 'fea'
  | 'objectives'
  | 'outer_loop'
  | 'layers'
  | 'toolpaths'
  | 'waypoints'
  | 'motion'
  | 'export'
  | 'metrics';

/** What an error, a warning or progress may name beside the stages: steps inside of `outer_loop`. */
export type Step = Stage | 'quaternion_field' | 'deformation' | 'scalar_field';

export type StageState =
  | 'fresh' // never done
  | 'running'
  | 'done'
  | 'stale' // done before, but its input or parameters have changed since
  | 'failed';

export type Point = [x: number, y: number, z: number];

export interface Warning {
  code: string;
  message: string;
  /** Places in the part, mm; may be empty. */
  where: Point[];
}

export interface StageInfo {
  stage: Stage;
  /** For people, as "Tetrahedra". */
  label: string;
  state: StageState;
  /** Wall seconds of the last run. */
  seconds: number;
  /** CPU seconds of the last run; null before it, and with threads, where they cannot be measured. */
  cpuSeconds: number | null;
  warnings: Warning[];
}

// --- errors ----------------------------------------------------------------------------------------------------------

/**
 * What goes wrong.
 *
 * | kind | means | what to do |
 * |---|---|---|
 * | `input` | model, parameters, load case or machine profile are wrong | say message and hint, show the places |
 * | `slicing` | a valid input could not be finished | the same |
 * | `cancelled` | cancel() was called; code `cancelled`. Finished stages keep their results | nothing |
 * | `engine` | code `engine.crashed`: a trap, or memory ran out. The engine and all its slicers are dead; code `engine.load`: it could not be loaded; code `engine.usage`: a method was called wrongly | load() a new engine (in a page: in a new worker), give it model and settings again |
 */
export class SlicerError extends Error {
  readonly name: 'SlicerError';
  readonly kind: 'input' | 'slicing' | 'cancelled' | 'engine';
  /** Stable text, first the stage, then the case: "mesh.open_boundary". */
  readonly code: string;
  /** Where it happened; null where no stage was involved. */
  readonly stage: Step | null;
  /** What to do about it; may be empty. */
  readonly hint: string;
  /** Places to highlight, mm; may be empty. In the file's frame for stage `mesh`, in the rest frame later. */
  readonly places: Point[];
  constructor(fields: SlicerErrorFields);
  /** For postMessage: structured cloning loses own classes. */
  toJSON(): SlicerErrorFields;
  /** The inverse of toJSON(). */
  static from(fields: SlicerErrorFields): SlicerError;
}

export interface SlicerErrorFields {
  kind: SlicerError['kind'];
  code: string;
  stage: Step | null;
  message: string;
  hint: string;
  places: Point[];
}

// --- loading ---------------------------------------------------------------------------------------------------------

export interface LoadOptions {
  /**
   * Threads that compute, the calling one included. Default: as many as there are processors (at most 16) where threads
   * work (Node; pages that are cross-origin isolated), else 1. 1 takes the single-threaded artefact. A number above 1
   * where threads do not work is an error. Results do not depend on it.
   */
  threads?: number;
  /**
   * Folder of the artefacts (`s3slicer.mjs`, `s3slicer.wasm`, `s3slicer-threads.*`), with a slash at the end. Default:
   * `dist/` beside index.js. Relative addresses count from the page or worker.
   */
  baseUrl?: string | URL;
  /** The bytes of the .wasm file, where they are already there: it is not fetched then. */
  wasmBinary?: ArrayBuffer | Uint8Array;
  /**
   * The memory to work in, for another limit than 4 GB: `new WebAssembly.Memory({initial: 1024, maximum: PAGES})`, at
   * least 1024 pages of 64 kB, `shared` with threads.
   */
  memory?: WebAssembly.Memory;
}

/**
 * Loads and starts the engine. May be called again for another one with its own memory.
 * @throws {SlicerError} `engine.load`
 */
export function load(options?: LoadOptions): Promise<Engine>;

/** Whether threads work here: Node, or a page that is cross-origin isolated. */
export function threadsAvailable(): boolean;

export interface Engine {
  readonly version: string;
  /** Threads that compute, the calling one included. */
  readonly threads: number;
  /** True after a trap: every further call throws `engine.crashed`. */
  readonly crashed: boolean;
  /** Bytes of WebAssembly memory: it grows and never shrinks. */
  readonly memoryBytes: number;
  /** Bytes of it that are in use. */
  readonly memoryUsed: number;
  createSlicer(): Slicer;
  /** The JSON Schema (2020-12) of all parameters, as `s3slice schema` prints it. Nests at the dots of the keys. */
  schema(): JsonSchema;
  /** Names of the bundled machine profiles, for the parameter `machine`. */
  machines(): string[];
  /** A bundled profile, with every key that setMachineProfile() reads. */
  machineProfile(name: string): MachineProfile;
  /**
   * What a model file holds, what repair would do about it: as `s3slice inspect --json`. Takes as long as the stage
   * `mesh`.
   */
  inspect(bytes: Bytes, fileName: string): Inspection;
  /** Stops the engine's threads and forgets its memory. Its slicers are dead. */
  dispose(): void;
}

export type Bytes = Uint8Array | ArrayBuffer;

/** An object, or in the leaves: key, title, type, unit, description, default, minimum, maximum, enum, stage, x-advanced. */
export interface JsonSchema {
  type: string;
  properties?: Record<string, JsonSchema>;
  title?: string;
  description?: string;
  /** The whole key with its dots. */
  key?: string;
  unit?: string;
  default?: number | string | boolean;
  minimum?: number;
  maximum?: number;
  enum?: string[];
  stage?: Step;
  'x-advanced'?: boolean;
  [other: string]: unknown;
}

/** Keys are those of a profile file: see core/motion/machine_profile.h. */
export interface MachineProfile {
  name: string;
  description: string;
  kinematics: 'cartesian' | 'table_bc' | 'head_ab';
  max_tilt_deg: number;
  head_cone_angle_deg: number;
  [key: string]: unknown;
}

export interface Defect {
  count: number;
  /** The first hundred places, mm, in the file's frame. */
  where: Point[];
}

/** As `s3slice inspect --json`; which keys are there depends on the kind of file. */
export interface Inspection {
  file: string;
  /** "stl-binary", "3mf", "tet" … */
  format: string;
  is_volume: boolean;
  /** Names of the parts, where there are several. */
  parts?: string[];
  min_mm: Point;
  max_mm: Point;
  size_mm: Point;
  vertices: number;
  area_mm2: number;
  volume_mm3: number;
  /** Sentences. */
  warnings: string[];
  /** Poses for `input.rotate`, best first. */
  orientations?: {
    rotate: string;
    overhang_area_mm2: number;
    support_volume_mm3: number;
    contact_area_mm2: number;
    height_mm: number;
    tipping_deg: number;
    stable: boolean;
  }[];

  // Surfaces only.
  triangles?: number;
  closed?: boolean;
  valid?: boolean;
  open_edges?: Defect;
  nonmanifold_edges?: Defect;
  inconsistent_edges?: Defect;
  nonmanifold_vertices?: Defect;
  degenerate_triangles?: Defect;
  duplicate_triangles?: Defect;
  self_intersections?: Defect;
  unused_vertices?: number;
  shells?: { triangles: number; volume_mm3: number; cavity: boolean; inverted: boolean }[];
  /** What repair changes. */
  repairs?: { code: string; sentence: string; count: number; where: Point[] }[];
  valid_after_repair?: boolean;
  volume_after_repair_mm3?: number;
  rebuild_reason?: string;
  /** The mesher that would take it. */
  mesher?: 'tetgen' | 'stuffing';
  /** Why the file cannot be sliced; absent when it can. */
  refused?: string;

  // Volumes only.
  tets?: number;
  boundary_faces?: number;
  min_dihedral_deg?: number;
  max_dihedral_deg?: number;
  tets_below_10_deg?: number;
}

// --- the slicer ------------------------------------------------------------------------------------------------------

/** Nested ({mesh: {target_tets: 5000}}) or with dotted keys ({'mesh.target_tets': 5000}), or both. */
export type Params = { [key: string]: number | string | boolean | Params };

export interface Progress {
  /** The stage or, inside `outer_loop`, the step that reports. */
  stage: Step;
  /** Of that stage or step, in [0, 1]. */
  fraction: number;
}

/**
 * Called on the computing thread, at most every 50 ms. May call cancel() and nothing else of the slicer. What it throws
 * ends the unit and arrives at the caller of advance().
 */
export type OnProgress = (progress: Progress) => void;

export interface RunOptions {
  onProgress?: OnProgress;
  /** Called after each unit that was done. */
  onStage?: (info: StageInfo) => void;
}

/** The result of advance(): the stage that this call has finished. `done` with null: there was nothing left to do. */
export type Advance = { state: 'running'; stage: Stage } | { state: 'done'; stage: Stage | null };

/** Which print: the field's layers, or the baseline of planar layers (there after the stage `metrics`). */
export type Which = 'curved' | 'planar';

export interface ArrayOptions {
  /** Bits of the reals: 32 (default) or 64. */
  precision?: 32 | 64;
}
export interface PrintOptions extends ArrayOptions {
  which?: Which;
}
export type Reals = Float32Array | Float64Array;

export interface InputFile {
  name: string;
  bytes: Uint8Array;
}

export interface Slicer {
  // --- input. Each marks stale what depends on a change, and nothing where nothing changes.

  /** The model file, in any format that the core reads (STL, OBJ, PLY, 3MF, OFF, .tet, .msh, VTU; also gzipped). */
  setModel(bytes: Bytes, fileName: string): void;
  /** The stress of every tet of a volume file (CSV or VTU): sets `strength.stress_file`; null takes it away. */
  setStress(bytes: Bytes | null, fileName?: string): void;
  /**
   * The load case: the file's bytes, its text, or the object. Sets `strength.load_case`; null takes it away.
   * @throws {SlicerError} `fea.bad_load_case` with the place in the file
   */
  setLoadCase(loadCase: Bytes | string | object | null, fileName?: string): void;
  /**
   * The tets that are critical beside those of the largest tension: a region file as bytes, text or object. Sets
   * `strength.critical_region`; null takes it away.
   * @throws {SlicerError} `fea.bad_region` with the place in the file
   */
  setCriticalRegion(region: Bytes | string | object | null, fileName?: string): void;
  /**
   * The faces that surface quality is for: a region file as bytes, text or object. Sets `objectives.surface_region`;
   * null takes it away.
   * @throws {SlicerError} `objectives.bad_region` with the place in the file
   */
  setSurfaceRegion(region: Bytes | string | object | null, fileName?: string): void;
  /**
   * Sets the parameters that are named; the others keep their values.
   * @throws {SlicerError} `params.unknown_key`, `params.wrong_type`, `params.out_of_range`, `machine.unknown`: names
   * key, value and range. Nothing is changed then.
   */
  setParams(params: Params): void;
  /** All parameters to their defaults, then setParams(). */
  resetParams(params?: Params): void;
  /**
   * A machine profile of one's own, as text or object in the form of a profile file; taken where the parameter `machine`
   * is `name`. setParams({machine: name}) selects it.
   * @throws {SlicerError} `machine.bad_profile`
   */
  setMachineProfile(name: string, profile: string | object): void;

  /** The parameters as given, nested: 0 still stands for "derived". What a project or a form keeps. */
  givenParams(): Params;
  /** The effective parameters, nested: nothing left to be derived. As job.json. */
  params(): Params;
  /** Copies of the files that were set, also by openProject(); null where there is none. */
  inputFiles(): Record<'model' | 'loadCase' | 'stress' | 'criticalRegion' | 'surfaceRegion', InputFile | null>;
  schema(): JsonSchema;
  /** The model that was set, as Engine.inspect(). */
  inspect(): Inspection;

  // --- running

  stages(): StageInfo[];
  /**
   * Runs one unit: the first stage that is not done.
   * @throws {SlicerError} the stage is `failed`, earlier stages keep their results; `cancelled`: the stage is as before,
   * and the cancel has been used up
   */
  advance(onProgress?: OnProgress): Advance;
  /** Runs every stage up to and including `last` that is not done, and lets events happen between the units. */
  runTo(last: Stage, options?: RunOptions): Promise<void>;
  /** Runs everything that is not done. */
  run(options?: RunOptions): Promise<void>;
  /**
   * Ends the running unit at its next checkpoint, or the next advance() at once. From the computing thread it can be
   * called in callbacks and between units; from others, see cancelFlag. Holds for all slicers of an engine.
   */
  cancel(): void;
  /** Forgets a cancel that came too late to end anything. run() and runTo() begin with it. */
  clearCancel(): void;
  /**
   * One shared byte that other threads may set with `Atomics.store(flag, 0, 1)` to cancel the running unit. Post it to
   * the page once: it stays the same for an engine's life. Null in the single-threaded artefact, whose memory nobody
   * else can reach: there only cancel() works, between units and in callbacks.
   */
  readonly cancelFlag: Uint8Array | null;

  // --- results: null where the stage in [brackets] is not done

  /** The model as the file gives it, in the file's frame, for showing it before anything is computed. */
  fileSurface(): FileSurface;
  /** [mesh] From the file's frame to the rest frame: 4×4, column by column, as three.js has it. */
  placement(): Float64Array | null;
  /** [mesh] The repaired surface standing on the plate; of a volume file its boundary. */
  surface(options?: ArrayOptions): Surface | null;
  /** [tetrahedralize; mesh for volume files] The rest mesh. Its order of tets is that of all per-tet arrays. */
  tets(options?: ArrayOptions): TetArrays | null;
  /** [fea] null too where there is neither load case nor stress file. */
  stress(options?: ArrayOptions): StressArrays | null;
  /** [objectives] What each boundary face asks for. */
  faces(options?: ArrayOptions): FaceArrays | null;
  /** [outer_loop] */
  deformation(options?: ArrayOptions): DeformationArrays | null;
  /** [outer_loop] Angles of boundary faces against the layers, with flags; `planar` is known at once too. */
  faceAngles(options?: PrintOptions): FaceAngles | null;
  /** [outer_loop] What the histograms show; `planar` is known at once too. */
  histogramData(options?: PrintOptions): HistogramData | null;
  /** [outer_loop] Face-adjacent tets between which the head would gouge. */
  gouging(options?: ArrayOptions): Gouging | null;
  /** [layers; metrics for `planar`] */
  layers(options?: PrintOptions): LayerArrays | null;
  /** [waypoints; metrics for `planar`] */
  waypoints(options?: PrintOptions): WaypointArrays | null;
  /** [motion] */
  motion(options?: ArrayOptions): MotionArrays | null;
  /** [metrics] As in report.json. */
  metrics(): { curved: Metrics; planar: Metrics } | null;
  /** report.json as an object, at any time: what was not computed is null. */
  report(): Report;
  /** [metrics] Histograms as SVG. */
  plots(): { name: string; svg: string }[] | null;

  // --- files

  /** What can be exported now. */
  listExports(): ExportInfo[];
  /**
   * @param name  of listExports()
   * @throws {SlicerError} `export.unknown_file` with the names there are
   */
  exportFile(name: string): Uint8Array;

  /**
   * Model, parameters, load case, regions, stress and machine profile as one ZIP file (stored, not packed): job.json beside the
   * files that it names, so that unpacked it runs natively too, with `s3slice run --config job.json -o OUTDIR`.
   * @param extra  anything of the caller's that survives JSON
   */
  saveProject(extra?: unknown): Uint8Array;
  /**
   * Takes model, settings and loads from saveProject().
   * @return what was given as `extra`, or null
   * @throws {SlicerError} `project.bad_file`
   */
  openProject(bytes: Bytes): unknown;

  /** Frees its memory for other slicers of the engine. Further calls throw `engine.usage`. */
  dispose(): void;
}

/**
 * Files as one ZIP archive, stored and not packed; equal files give equal archives.
 */
export function writeZip(entries: readonly InputFile[]): Uint8Array<ArrayBuffer>;

// --- arrays ----------------------------------------------------------------------------------------------------------

export interface Surface {
  /** #V×3 mm. */
  positions: Reals;
  /** #F×3, counter-clockwise from outside. */
  indices: Uint32Array;
}

export interface FileSurface extends Surface {
  /** #F: the part of each triangle; null for volume files. */
  partOfTriangle: Uint32Array | null;
  partNames: string[];
}

export interface TetArrays {
  /** #V×3 mm, rest frame. */
  positions: Reals;
  /** #T×4 vertices, positive volume. */
  tets: Uint32Array;
  /** #B×3 vertices, counter-clockwise from outside. */
  boundaryFaces: Uint32Array;
  /** #B: the tet behind each boundary face. */
  boundaryTets: Uint32Array;
}

export interface StressArrays {
  /** #T×3 unit: direction of the largest principal stress. */
  tauMax: Reals;
  /** #T MPa: the largest principal stress, tension positive. */
  sigmaMax: Reals;
  /** #T: 1 in the critical region S. */
  critical: Uint8Array;
  /** #T×6 MPa: xx yy zz yz zx xy; null where only directions are known. */
  tensors: Reals | null;
}

/** Over the boundary faces of tets(). */
export interface FaceArrays {
  /** #B×3 unit, outward. */
  normals: Reals;
  /** #B mm². */
  areas: Reals;
  /** #B: 1 on the plate, where no objective applies. */
  exempt: Uint8Array;
  /** #B: 1 where surface quality applies. */
  wantsQuality: Uint8Array;
}

export interface DeformationArrays {
  /** #V×3 mm: M^d. */
  deformed: Reals;
  /** #V mm: G, whose isosurfaces are the layers. */
  field: Reals;
  /** #T×3 unit: the local printing direction ∇G/‖∇G‖. */
  printDirections: Reals;
  /** #T mm per mm: ‖∇G‖. */
  gradientLengths: Reals;
  /** #T×4: the rotation of each tet, x y z w. */
  rotations: Reals;
  /** Mean Π, rad, after each outer iteration. */
  residuals: Float64Array;
  outerIterations: number;
  islands: { place: Point; volume: number; depth: number }[];
}

/** Over the boundary faces of tets(). */
export interface FaceAngles {
  /** #B degrees between outward normal and printing direction, in [0, 180]; 180 where there is none. */
  supportFree: Reals;
  /** #B degrees between ±normal and printing direction, in [0, 90]: best near 0 and near 90. */
  surfaceQuality: Reals;
  /** #B: 1 where the face overhangs its layer by more than objectives.alpha; 0 on the plate. */
  overhang: Uint8Array;
  /** #B: 1 where stair-steps show: farther than 10° from both 0° and 90°; 0 on the plate. */
  stairs: Uint8Array;
}

export interface WeightedValues {
  values: Reals;
  /** mm² for faces and layers, 1 for tets. */
  weights: Reals;
}

export interface HistogramData {
  /** Degrees between normal and printing direction: at most 135 prints without support. */
  supportFree: WeightedValues;
  /** Degrees in [0, 90]: best near 0 and 90. */
  surfaceQuality: WeightedValues;
  /** Degrees between τ_max of critical tets and the layer, in [0, 90]: best near 0. Empty without stress. */
  strength: WeightedValues;
  /** Thickness of layers, mm, by area. Empty before the stage that makes them. */
  thickness: WeightedValues;
}

export interface Gouging {
  /** #N×2: the tets of each pair. */
  pairs: Uint32Array;
  /** #N×3 mm: the middle of the face that they share. */
  places: Reals;
  /** #N degrees by which the layer is concave there, above `clearance`. */
  angles: Reals;
  /** Degrees that the machine's head leaves: 90° − θ/2. */
  clearance: number;
}

/**
 * Components of layers in print order, packed. Component c has the vertices [vertexOffsets[c], vertexOffsets[c + 1]) and
 * the entries [indexOffsets[c], indexOffsets[c + 1]) of indices: one buffer, one draw call, and a range of layers is a
 * draw range.
 */
export interface LayerArrays {
  count: number;
  /** #V×3 mm. */
  positions: Reals;
  /** #V×3 unit. */
  normals: Reals;
  /** #V mm: distance to the material below. */
  thickness: Reals;
  /** #F×3 into positions as a whole. */
  indices: Uint32Array;
  /** #F: a tet that the triangle lies in. Of planar layers too. */
  sourceTets: Uint32Array;
  vertexOffsets: Uint32Array;
  indexOffsets: Uint32Array;
  /** #count mm: of G. */
  isoValues: Float64Array;
  /** #count: number of the isosurface, from below. */
  isosurfaces: Uint32Array;
  /** #count: 1 where the isosurface was cut. */
  partial: Uint8Array;
  /** Components below that carry component c: restsOn[restsOnOffsets[c]] and on. */
  restsOn: Uint32Array;
  restsOnOffsets: Uint32Array;
  unsupportedArea: number;
  unsupportedPlaces: Point[];
  droppedArea: number;
  droppedPlaces: Point[];
}

/** The kinds of WaypointArrays.kind. */
export const pathKinds: readonly ['wall', 'infill', 'gap_fill'];

/** #W waypoints in print order, rest frame. */
export interface WaypointArrays {
  count: number;
  /** #W×3 mm: the nozzle's tip. */
  positions: Reals;
  /** #W×3 unit: away from the material; the nozzle points against it. */
  normals: Reals;
  /** #W×3 unit: direction of travel. */
  tangents: Reals;
  /** #W mm: bead width and height. */
  widths: Reals;
  heights: Reals;
  /** #W mm of filament pushed on the way from the waypoint before; 0 on travels. */
  extrusions: Reals;
  /** #W mm/s on the way to this waypoint. */
  speeds: Reals;
  /** #W degrees between normal and z. */
  tilts: Reals;
  /** #W: position in LayerArrays. */
  components: Uint32Array;
  /** #W: number of the isosurface. */
  layers: Uint32Array;
  /** #W: running number of the path. */
  paths: Uint32Array;
  /** #W: position in pathKinds. */
  kinds: Uint8Array;
  /** #W: 1 if the way to this waypoint is made without extruding. */
  travels: Uint8Array;
}

export interface MotionArrays {
  /** mm, added to the waypoints' positions. */
  partOffset: Point;
  /** #M×6: x y z (mm), a b c (degrees) at the end of each move. */
  poses: Reals;
  /** #M s. */
  durations: Reals;
  /** #M mm of filament. */
  extrusions: Reals;
  /** #M: the waypoint that the move leads to, or towards. */
  waypoints: Uint32Array;
  /** #M: 1 where the move ends at that waypoint. */
  arrives: Uint8Array;
  /** #W s since the start at each waypoint, for a playhead. */
  times: Reals;
}

/** What was not computed is null. */
export interface Metrics {
  support_free_area_percent: number | null;
  support_free_mean_violation_deg: number | null;
  surface_quality_area_percent: number | null;
  /** Of the faces in objectives.surface_region; null without one. */
  surface_quality_region_percent: number | null;
  strength_critical_percent: number | null;
  pi_rad: number | null;
  foldovers: number | null;
  gouging_pairs: number | null;
  concave_pairs_over_20deg: number | null;
  islands: number | null;
  layers: number | null;
  components: number | null;
  thickness_mm: { min: number; p1: number; p50: number; p99: number; max: number } | null;
  thickness_outside_area_percent: number | null;
  path_length_mm: number | null;
  coverage_percent: number | null;
  overlap_percent: number | null;
  surface_error_mm: { avg: number; max: number } | null;
  strain: { max: number; mean: number; [key: string]: number } | null;
  support_volume_mm3: number | null;
  material_g: number | null;
  print_time_s: number | null;
  [key: string]: unknown;
}

/** report.json. */
export interface Report {
  s3slice: string;
  input: Record<string, unknown>;
  mesh: Record<string, unknown>;
  timings_s: Record<string, number | null>;
  cpu_s: Record<string, number | null>;
  threads: number;
  peak_memory_mb: number;
  outer_iterations: number | null;
  pi_rad: number[];
  curved: Metrics;
  planar: Metrics;
  warnings: Warning[];
  [key: string]: unknown;
}

export interface ExportInfo {
  /** As in the folder of `s3slice run`: "program.gcode", "layers/0003.ply". */
  name: string;
  /** The stage that it is a result of; null for job.json and report.json. */
  stage: Stage | null;
  /** MIME type. */
  type: string;
}

// What the viewport shows: chooses the view, feeds it with results, colours it, and answers clicks on it.
import * as THREE from 'three';
import type { DeformationArrays, FaceAngles, FaceArrays, Gouging, LayerArrays, MotionArrays, StressArrays, TetArrays, WaypointArrays } from '../../../wasm/index.js';
import type { App } from '../app.ts';
import { KIND_COLORS, TRAVEL_COLOR, WARNING_COLOR, colorize, extent, layerColor, robustExtent } from '../color_maps.ts';
import type { MapName, Rgb } from '../color_maps.ts';
import { h, icon, replace, segmented, slider } from '../dom.ts';
import { number, printTime } from '../format.ts';
import { showLegend } from '../legend.ts';
import type { LegendContent } from '../legend.ts';
import { facesOf, hasLoads, triangleNeighbors } from '../load_case.ts';
import type { LoadRegion, Patch, SurfaceShape } from '../load_case.ts';
import type { LoadEditor } from '../panels/loads_panel.ts';
import { regionColor } from '../panels/loads_panel.ts';
import { formatRotation, layOnPlate, scaleOf, transformPoint, untransformPoint } from '../rotation.ts';
import type { Vec } from '../rotation.ts';
import { makeTimeline } from '../timeline.ts';
import type { Timeline } from '../timeline.ts';
import { LayerView } from './layer_view.ts';
import { SolidView } from './solid_view.ts';
import type { SolidColors } from './solid_view.ts';
import { SurfaceView } from './surface_view.ts';
import { ToolpathView } from './toolpath_view.ts';
import { Viewer, boxOf } from './viewer.ts';
import type { Direction } from './viewer.ts';

export type ViewName = 'model' | 'mesh' | 'shape' | 'field' | 'stress' | 'layers' | 'paths';
const VIEWS: { value: ViewName; text: string; title: string; stage: string }[] = [
  { value: 'model', text: 'Part', title: 'The surface', stage: '' },
  { value: 'mesh', text: 'Mesh', title: 'The tets, cut open', stage: 'tetrahedralize' },
  { value: 'stress', text: 'Stress', title: 'Tension in the part', stage: 'fea' },
  { value: 'shape', text: 'Shape', title: 'From rest to deformed: flat layers there are curved layers here', stage: 'outer_loop' },
  { value: 'field', text: 'Field', title: 'The layers\' height field and print directions', stage: 'outer_loop' },
  { value: 'layers', text: 'Layers', title: 'The curved layers', stage: 'layers' },
  { value: 'paths', text: 'Toolpaths', title: 'What the nozzle lays', stage: 'waypoints' },
];

type FieldColor = 'height' | 'tilt' | 'overhang' | 'stairs' | 'gouging';
type StressColor = 'tension' | 'critical';
type LayerColor = 'layer' | 'thickness' | 'tilt' | 'cut';
type PathColor = 'kind' | 'layer' | 'thickness' | 'speed' | 'tilt';

interface Display {
  cutAxis: 'off' | 'x' | 'y' | 'z';
  cutAt: number;  // share of the box
  arrows: boolean;
  edges: boolean;
  deform: number;
  field: FieldColor;
  stress: StressColor;
  layerColor: LayerColor;
  explode: number;  // share of the part's height
  pathColor: PathColor;
  travels: boolean;
  planar: boolean;
}

export class Workspace {
  readonly viewer: Viewer;
  view: ViewName = 'model';
  /** Whether results of the view are still on their way. */
  loading = false;
  #app: App;
  #loads: LoadEditor;
  #surface = new SurfaceView();
  #solid = new SolidView();
  #layers = new LayerView();
  #paths = new ToolpathView();
  #pin = marker();
  #forces = new THREE.Group();
  #display: Display = {
    cutAxis: 'off', cutAt: 0.5, arrows: false, edges: true, deform: 0, field: 'height', stress: 'tension', layerColor: 'layer', explode: 0, pathColor: 'kind', travels: false, planar: false,
  };
  #shownSurface: { positions: ArrayLike<number>; indices: Uint32Array } | null = null;
  #surfaceIsRest = false;
  #shape: SurfaceShape | null = null;
  /** Faces of each patch on the surface that is shown. */
  #patchFaces = new WeakMap<Patch, number[]>();
  #tets: TetArrays | null = null;
  #deformation: DeformationArrays | null = null;
  #stressData: StressArrays | null = null;
  #angles: FaceAngles | null = null;
  #faces: FaceArrays | null = null;
  #gouging: Gouging | null = null;
  #gouges = marker();
  #layerData: LayerArrays | null = null;
  #waypoints: WaypointArrays | null = null;
  #motion: MotionArrays | null = null;
  #switch;
  #timeline: Timeline;
  #legendHost: HTMLElement;
  #displayHost: HTMLElement;
  #infoHost: HTMLElement;
  #marksHost: HTMLElement;
  #handles = new Map<number, HTMLElement>();
  #laying: ((done: void) => void) | null = null;
  #round = 0;
  #follow = false;
  #marks: { places: [number, number, number][]; frame: 'file' | 'rest' } = { places: [], frame: 'rest' };

  constructor(app: App, loads: LoadEditor, hosts: Record<'canvas' | 'views' | 'display' | 'legend' | 'info' | 'timeline' | 'marks', HTMLElement>) {
    this.#app = app;
    this.#loads = loads;
    this.viewer = new Viewer(hosts.canvas);
    this.#legendHost = hosts.legend;
    this.#displayHost = hosts.display;
    this.#infoHost = hosts.info;
    this.#marksHost = hosts.marks;
    for (const part of [this.#surface.group, this.#solid.group, this.#layers.group, this.#paths.group, this.#forces, this.#gouges, this.#pin]) this.viewer.scene.add(part);
    this.#switch = segmented('View', VIEWS, 'model', (view) => { this.#follow = false; void this.show(view); });
    replace(hosts.views, this.#switch.element);
    hosts.views.hidden = true;
    this.#timeline = makeTimeline(hosts.timeline, {
      onrange: (from, to) => this.#setRange(from, to),
      onplayhead: (at) => this.#setPlayhead(at),
    });
    this.viewer.onFrame = () => this.#placeHandles();
    this.#listen(hosts.views);
    this.#pointer(hosts.canvas);
  }

  // --- following the app

  #listen(views: HTMLElement): void {
    const app = this.#app;
    app.on('model', () => {
      this.#forget();
      views.hidden = app.model === null;
      if (app.model) {
        this.#useSurface(app.model.surface, false);
        this.#surfaceBox(true);
      }
      void this.show('model');
    });
    app.on('placement', () => {
      if (!this.#shownSurface || this.#surfaceIsRest) return;
      this.#surface.setMatrix(app.placement);
      this.#surfaceBox(true);
      this.#paintSurface();
    });
    app.on('done', (stage) => void this.#onDone(stage));
    app.on('settings', () => this.#paintSurface());
    app.on('stages', () => this.#enableViews());
    app.on('running', () => {
      if (app.running && app.running.until !== 'mesh') this.#follow = true;
      this.#enableViews();
    });
    this.#enableViews();
  }

  async #onDone(stage: string): Promise<void> {
    const app = this.#app;
    if (stage === 'mesh') {
      const surface = await app.result('surface');
      if (surface) {
        this.#useSurface(surface, true);
        this.#surfaceBox(!app.running || app.running.until === 'mesh');
        this.#paintSurface();
      }
    }
    if (stage === 'tetrahedralize') this.#tets = this.#stressData = this.#deformation = this.#angles = this.#gouging = null;
    if (stage === 'fea') this.#stressData = null;
    if (stage === 'outer_loop') this.#deformation = this.#angles = this.#faces = this.#gouging = null;
    if (stage === 'layers' || (stage === 'metrics' && this.#display.planar)) this.#layerData = null;
    if (stage === 'waypoints' || (stage === 'metrics' && this.#display.planar)) this.#waypoints = null;
    if (stage === 'motion') this.#motion = null;
    this.#enableViews();
    if (stage === 'metrics') this.#showDisplay();
    if (this.#follow && stage === 'layers') await this.show('layers');
    else if (VIEWS.find((one) => one.value === this.view)?.stage === stage || (this.view === 'paths' && stage === 'motion')) await this.show(this.view, true);
  }

  #enableViews(): void {
    const app = this.#app;
    for (const { value, stage, title } of VIEWS) {
      const stress = value === 'stress' && !app.settings.stress && !app.settings.files.loads && !hasLoads(app.settings.loads);
      const there = stage === '' || (app.has(stage as never) && !stress);
      this.#switch.enable(value, there, there ? title : stress ? `${title}: needs loads` : `${title}: slice first`);
    }
  }

  #forget(): void {
    this.#surface.clear();
    this.#solid.clear();
    this.#layers.clear();
    this.#paths.clear();
    this.#tets = this.#deformation = this.#stressData = this.#angles = this.#faces = this.#gouging = this.#layerData = this.#waypoints = this.#motion = null;
    this.#shownSurface = this.#shape = null;
    this.#pin.visible = false;
    this.#marks = { places: [], frame: 'rest' };
    Object.assign(this.#display, { cutAxis: 'off', deform: 0, explode: 0, planar: false });
    replace(this.#infoHost);
  }

  #useSurface(surface: { positions: ArrayLike<number>; indices: Uint32Array }, rest: boolean): void {
    this.#shownSurface = surface;
    this.#surfaceIsRest = rest;
    this.#shape = null;
    this.#patchFaces = new WeakMap();
    this.#surface.set(surface as never, rest ? new THREE.Matrix4().elements : this.#app.placement);
    if (this.#marks.places.length > 0) this.mark(this.#marks.places, this.#marks.frame);
  }

  #surfaceBox(look: boolean): void {
    const surface = this.#shownSurface;
    const box = surface && boxOf(surface.positions, this.#surfaceIsRest ? undefined : this.#app.placement);
    if (!box) return;
    if (look) this.viewer.show(box);
    else this.viewer.setBox(box);
  }

  // --- views

  async show(view: ViewName, keep = false): Promise<void> {
    const round = ++this.#round;
    this.view = view;
    this.loading = true;
    this.#switch.set(view);
    if (!keep) {
      this.#pin.visible = false;
      replace(this.#infoHost);
    }
    await this.#load(view);
    if (round !== this.#round) return;
    this.#gouges.visible = false;
    this.#surface.group.visible = view === 'model';
    this.#solid.group.visible = view === 'mesh' || view === 'shape' || view === 'field' || view === 'stress';
    this.#layers.group.visible = view === 'layers';
    this.#paths.group.visible = view === 'paths';
    this.#showDisplay();
    this.#refresh();
    this.#showTimeline();
    this.#placeHandles();
    this.loading = false;
  }

  async #load(view: ViewName): Promise<void> {
    const app = this.#app;
    if (view === 'mesh' || view === 'shape' || view === 'field' || view === 'stress') {
      if (!this.#tets) {
        this.#tets = await app.result('tets');
        if (this.#tets) this.#solid.set(this.#tets);
      }
      this.#deformation ??= await app.result('deformation');
      this.#angles ??= await app.result('faceAngles');
      this.#faces ??= await app.result('faces');
      this.#gouging ??= await app.result('gouging');
      if (view === 'stress') this.#stressData ??= await app.result('stress');
    }
    if (view === 'layers' || view === 'paths') {
      if (!this.#layerData) {
        this.#layerData = await app.result('layers', this.#display.planar ? 'planar' : 'curved');
        if (this.#layerData) this.#layers.set(this.#layerData);
      }
    }
    if (view === 'paths') {
      if (!this.#waypoints) {
        this.#waypoints = await app.result('waypoints', this.#display.planar ? 'planar' : 'curved');
        if (this.#waypoints) this.#paths.set(this.#waypoints, Number(app.param('nozzle.diameter')));
      }
      this.#motion ??= await app.result('motion');
    }
  }

  /** Colours and geometry of the view after its display options changed. */
  #refresh(): void {
    if (this.view === 'model') this.#paintSurface();
    else if (this.view === 'layers') this.#paintLayers();
    else if (this.view === 'paths') this.#paintPaths();
    else this.#updateSolid();
    this.viewer.invalidate();
  }

  #legend(content: LegendContent | null): void {
    showLegend(this.#legendHost, content);
  }

  // --- solid

  #updateSolid(): void {
    const tets = this.#tets, display = this.#display;
    if (!tets) return;
    const { min, max } = this.viewer.box;
    const axis = this.view === 'shape' ? null : ({ off: null, x: 0, y: 1, z: 2 } as const)[display.cutAxis];
    // What stands between the camera and the cut is taken away.
    const below = axis === null || axis === 2 || this.viewer.camera.position.getComponent(axis) > (min[axis] + max[axis]) / 2;
    const cut = axis === null ? null : { axis, at: min[axis] + display.cutAt * (max[axis] - min[axis]), below };
    const deformation = this.#deformation;
    this.#solid.setDeformed(deformation?.deformed ?? null, deformation?.printDirections ?? null);
    this.#solid.setAmount(this.view === 'shape' ? display.deform : 0);
    const colors = this.#solidColors(tets);
    this.#gouges.visible = this.view === 'field' && display.field === 'gouging' && (this.#gouging?.angles.length ?? 0) > 0;
    if (this.#gouges.visible) this.#gouges.geometry.setAttribute('position', new THREE.BufferAttribute(this.#gouging!.places as Float32Array, 3));
    this.#solid.update({ cut, colors: colors.colors, arrows: this.view === 'field' && display.arrows, edges: display.edges });
    this.#legend(colors.legend);
    this.viewer.invalidate();
  }

  #solidColors(tets: TetArrays): { colors: SolidColors; legend: LegendContent | null } {
    const count = tets.tets.length / 4, deformation = this.#deformation;
    if (this.view === 'stress' && this.#stressData) {
      const { sigmaMax, critical } = this.#stressData;
      if (this.#display.stress === 'critical') {
        const rgb = new Uint8Array(3 * count);
        for (let t = 0; t < count; ++t) rgb.set(critical[t] ? WARNING_COLOR : [165, 176, 190], 3 * t);
        return { colors: { per: 'tet', rgb }, legend: { title: 'Critical region', keys: [{ color: WARNING_COLOR, text: 'critical' }, { color: [165, 176, 190], text: 'elsewhere' }] } };
      }
      const [low, high] = robustExtent(sigmaMax);
      const reach = Math.max(Math.abs(low), Math.abs(high)) || 1;
      return { colors: { per: 'tet', rgb: colorize(sigmaMax, 'diverging', -reach, reach) }, legend: { title: 'Largest principal stress', unit: 'MPa', map: 'diverging', low: -reach, high: reach, note: 'tension positive' } };
    }
    if (this.view === 'shape' && deformation) {
      const mean = (thicknessRange(this.#app)[0] + thicknessRange(this.#app)[1]) / 2;
      const [low, high] = extent(deformation.field);
      const layers = Math.max(1, Math.round((high - low) / mean / 15));  // in a band
      const level = Float32Array.from(deformation.field, (value) => value / (layers * mean));
      return { colors: { per: 'bands', level }, legend: { title: 'Layers', note: `Bands of ${layers === 1 ? 'one layer height' : `${layers} layer heights`}: flat in the deformed shape, curved in the part.` } };
    }
    if (this.view === 'field' && deformation) return this.#fieldColors(tets, deformation);
    return { colors: null, legend: null };
  }

  #fieldColors(tets: TetArrays, deformation: DeformationArrays): { colors: SolidColors; legend: LegendContent } {
    const count = tets.tets.length / 4;
    const scale = (per: 'tet' | 'vertex', values: ArrayLike<number>, map: MapName, range: [number, number], title: string, unit: string) =>
      ({ colors: { per, rgb: colorize(values, map, ...range) }, legend: { title, unit, map, low: range[0], high: range[1] } });
    if (this.#display.field === 'tilt') return scale('tet', tiltOf(deformation.printDirections, count), 'warm', [0, Math.max(10, extent(tiltOf(deformation.printDirections, count))[1])], 'Tilt of the print direction', '°');
    if (this.#display.field === 'gouging') {
      const places = this.#gouging?.angles.length ?? 0, clearance = number(this.#gouging?.clearance ?? 0);
      return { colors: null, legend: { title: 'Gouging', keys: [{ color: WARNING_COLOR, text: places > 0 ? `${places} places` : 'nowhere' }], note: `valleys steeper than the head's clearance of ${clearance}°` } };
    }
    const flags = this.#display.field === 'overhang' ? this.#angles?.overhang : this.#display.field === 'stairs' ? this.#angles?.stairs : null;
    if (flags) {
      const rgb = new Uint8Array(3 * count);
      for (let t = 0; t < count; ++t) rgb.set([165, 176, 190], 3 * t);
      // Stair-steps count in the painted region, where there is one.
      const asked = this.#display.field === 'stairs' ? this.#paintedFaces() : null;
      let found = false;
      flags.forEach((flag, face) => {
        if (!flag || (asked && !asked[face])) return;
        found = true;
        rgb.set(WARNING_COLOR, 3 * tets.boundaryTets[face]!);
      });
      const text = this.#display.field === 'overhang' ? 'overhangs its layer' : `shows stair-steps${asked ? ' where it is painted' : ''}`;
      return { colors: { per: 'tet', rgb }, legend: { title: this.#display.field === 'overhang' ? 'Overhang' : 'Stair-steps', keys: [{ color: WARNING_COLOR, text: found ? text : `${text}: nowhere` }] } };
    }
    return scale('vertex', deformation.field, 'viridis', extent(deformation.field), 'Height field G', 'mm');
  }

  /** 1 on faces that surface quality is asked of, where it is not all of them. */
  #paintedFaces(): Uint8Array | null {
    const faces = this.#faces;
    if (!faces || !faces.wantsQuality.includes(1)) return null;
    return faces.wantsQuality.some((wants, face) => !wants && !faces.exempt[face]) ? faces.wantsQuality : null;
  }

  // --- layers

  #paintLayers(): void {
    const layers = this.#layerData;
    if (!layers) return;
    const vertices = layers.positions.length / 3, mode = this.#display.layerColor;
    this.#layers.setExplode((this.#display.explode * (this.viewer.box.max[2] - this.viewer.box.min[2])) / Math.max(1, Math.max(...layers.isosurfaces)));
    if (mode === 'thickness') {
      const [low, high] = thicknessRange(this.#app);
      this.#layers.paint(colorize(layers.thickness, 'viridis', low, high));
      this.#legend({ title: 'Layer thickness', unit: 'mm', map: 'viridis', low, high });
    } else if (mode === 'tilt') {
      const tilts = tiltOf(layers.normals, vertices);
      const high = Math.max(10, extent(tilts)[1]);
      this.#layers.paint(colorize(tilts, 'warm', 0, high));
      this.#legend({ title: 'Tilt of the layer', unit: '°', map: 'warm', low: 0, high });
    } else {
      const rgb = new Uint8Array(3 * vertices);
      for (let c = 0; c < layers.count; ++c) {
        const color: Rgb = mode === 'layer' ? layerColor(layers.isosurfaces[c]!) : layers.partial[c] ? [224, 132, 60] : [120, 155, 190];
        for (let v = layers.vertexOffsets[c]!; v < layers.vertexOffsets[c + 1]!; ++v) rgb.set(color, 3 * v);
      }
      this.#layers.paint(rgb);
      const pieces = layers.count;
      this.#legend(mode === 'layer'
        ? { title: 'Layers', note: `${new Set(layers.isosurfaces).size} layers in ${pieces} pieces` }
        : { title: 'Partial layers', keys: [{ color: [224, 132, 60], text: 'cut short' }, { color: [120, 155, 190], text: 'whole' }] });
    }
    this.viewer.invalidate();
  }

  // --- toolpaths

  #paintPaths(): void {
    const w = this.#waypoints;
    if (!w) return;
    const mode = this.#display.pathColor;
    this.#paths.showTravels(this.#display.travels);
    const scale = (values: ArrayLike<number>, map: MapName, range: [number, number], title: string, unit: string): void => {
      this.#paths.paint(colorize(values, map, ...range));
      this.#legend({ title, unit, map, low: range[0], high: range[1] });
    };
    if (mode === 'thickness') scale(w.heights, 'viridis', thicknessRange(this.#app), 'Bead height', 'mm');
    else if (mode === 'speed') scale(w.speeds, 'viridis', robustExtent(printedOnly(w.speeds, w.travels), 0.02), 'Speed of the tip', 'mm/s');
    else if (mode === 'tilt') scale(w.tilts, 'warm', [0, Math.max(10, extent(w.tilts)[1])], 'Tilt of the nozzle', '°');
    else {
      const rgb = new Uint8Array(3 * w.count);
      for (let i = 0; i < w.count; ++i) rgb.set(mode === 'kind' ? (KIND_COLORS[w.kinds[i]!] ?? KIND_COLORS[0]!) : layerColor(w.layers[i]!), 3 * i);
      this.#paths.paint(rgb);
      const kinds = new Set(w.kinds);
      const keys = ['Walls', 'Infill', 'Gap fill'].map((text, i) => ({ text, color: KIND_COLORS[i]! })).filter((_, i) => kinds.has(i));
      if (this.#display.travels) keys.push({ text: 'Travel', color: TRAVEL_COLOR });
      this.#legend(mode === 'kind' ? { title: 'Toolpaths', keys } : { title: 'Layers' });
    }
    this.viewer.invalidate();
  }

  #showTimeline(): void {
    const layers = this.#layerData, waypoints = this.#waypoints;
    if (this.view === 'layers' && layers) {
      this.#timeline.show({ count: layers.count, describe: (from, to) => rangeOfLayers(layers, from, to), waypoints: null });
    } else if (this.view === 'paths' && layers && waypoints) {
      const begin = componentBegins(waypoints, layers.count);
      const times = this.#motion && this.#motion.times.length === waypoints.count && !this.#display.planar ? this.#motion.times : null;
      this.#timeline.show({
        count: layers.count, describe: (from, to) => rangeOfLayers(layers, from, to),
        waypoints: { begin, speeds: waypoints.speeds, positions: waypoints.positions, times },
      });
    } else {
      this.#timeline.hide();
    }
  }

  /** Components from (with) to (without). */
  #setRange(from: number, to: number): void {
    this.#layers.setRange(from, to);
    if (this.view === 'paths' && this.#waypoints && this.#layerData) {
      const begin = componentBegins(this.#waypoints, this.#layerData.count);
      this.#paths.setRange(begin[from]!, begin[to]!);
      this.#paths.setNozzle(null);
    }
    this.viewer.invalidate();
  }

  /** Prints up to a waypoint, nozzle there; null: everything of the range, no nozzle. */
  #setPlayhead(at: number | null): void {
    if (!this.#waypoints || !this.#layerData) return;
    const begin = componentBegins(this.#waypoints, this.#layerData.count);
    const [from, to] = this.#timeline.range;
    const end = at === null ? begin[to]! : Math.max(begin[from]!, Math.min(begin[to]!, Math.round(at) + 1));
    this.#paths.setRange(begin[from]!, end);
    this.#paths.setNozzle(at === null ? null : end - 1);
    this.viewer.invalidate();
  }

  // --- display options

  #showDisplay(): void {
    const display = this.#display, parts: (HTMLElement | null)[] = [];
    const pick = <Value extends string>(label: string, key: keyof Display, options: [Value, string][]): HTMLElement => {
      const select = h('select', { 'aria-label': label, onchange: () => { (display[key] as string) = select.value; this.#showDisplay(); this.#refresh(); } },
        ...options.map(([value, text]) => h('option', { value }, text)));
      select.value = String(display[key]);
      return h('label', { class: 'pick' }, h('span', {}, label), select);
    };
    const check = (label: string, key: 'arrows' | 'edges' | 'travels'): HTMLElement => {
      const input = h('input', { type: 'checkbox', checked: display[key], onchange: () => { display[key] = input.checked; this.#refresh(); } });
      return h('label', { class: 'check' }, input, label);
    };
    const share = (label: string, key: 'cutAt' | 'deform' | 'explode', apply: () => void): HTMLElement =>
      slider({ label, min: 0, max: 1, step: 0.005, value: display[key], show: (value) => `${Math.round(100 * value)} %`, oninput: (value) => { display[key] = value; apply(); this.viewer.invalidate(); } }).element;
    const solid = (): void => this.#updateSolidSoon();
    if (this.view === 'field') parts.push(pick<FieldColor>('Colour', 'field', [['height', 'Height field'], ['tilt', 'Tilt'], ['overhang', 'Overhang'], ['stairs', 'Stair-steps'], ['gouging', 'Gouging']]));
    if (this.view === 'stress') parts.push(pick<StressColor>('Colour', 'stress', [['tension', 'Tension'], ['critical', 'Critical region']]));
    if (this.view === 'shape') parts.push(share('Deformed', 'deform', () => this.#solid.setAmount(display.deform)));
    if (this.view === 'mesh' || this.view === 'field' || this.view === 'stress') {
      parts.push(pick('Cut', 'cutAxis', [['off', 'No cut'], ['x', 'Across x'], ['y', 'Across y'], ['z', 'Across z']]));
      if (display.cutAxis !== 'off') parts.push(share('Place', 'cutAt', solid));
    }
    if (this.view === 'field') parts.push(check('Print directions', 'arrows'));
    if (this.view === 'mesh' || this.view === 'field' || this.view === 'stress' || this.view === 'shape') parts.push(check('Edges of the tets', 'edges'));
    if (this.view === 'layers') {
      parts.push(pick<LayerColor>('Colour', 'layerColor', [['layer', 'Layer'], ['thickness', 'Thickness'], ['tilt', 'Tilt'], ['cut', 'Partial layers']]), share('Explode', 'explode', () => this.#paintExplode()));
    }
    if (this.view === 'paths') {
      parts.push(pick<PathColor>('Colour', 'pathColor', [['kind', 'Kind'], ['layer', 'Layer'], ['thickness', 'Bead height'], ['speed', 'Speed'], ['tilt', 'Tilt']]), check('Travels', 'travels'));
    }
    if ((this.view === 'layers' || this.view === 'paths') && this.#app.has('metrics')) {
      const choice = segmented('Which layers', [{ value: 'curved', text: 'Curved' }, { value: 'planar', text: 'Planar' }], display.planar ? 'planar' : 'curved', (value) => {
        display.planar = value === 'planar';
        this.#layerData = this.#waypoints = null;
        void this.show(this.view);
      });
      parts.push(choice.element);
    }
    replace(this.#displayHost, parts.length > 0 && this.#foldButton(), ...parts);
  }

  /** Where there is little room, the options are folded away until they are asked for; the style decides where. */
  #foldButton(): HTMLElement {
    const button = h('button', { class: 'fold', type: 'button', onclick: () => { this.#displayHost.classList.toggle('open'); tell(); } }, icon('chevron'), 'Display');
    const tell = (): void => button.setAttribute('aria-expanded', String(this.#displayHost.classList.contains('open')));
    tell();
    return button;
  }

  #solidAsked = 0;
  /** Once a frame is enough while a slider moves. */
  #updateSolidSoon(): void {
    if (this.#solidAsked) return;
    this.#solidAsked = requestAnimationFrame(() => {
      this.#solidAsked = 0;
      this.#updateSolid();
    });
  }

  #paintExplode(): void {
    const layers = this.#layerData;
    if (!layers) return;
    const height = this.viewer.box.max[2] - this.viewer.box.min[2];
    let top = 1;
    for (const level of layers.isosurfaces) top = Math.max(top, level);
    this.#layers.setExplode((this.#display.explode * height) / top);
  }

  // --- the surface: marks, loads, picking

  mark(places: readonly Vec[], frame: 'file' | 'rest'): void {
    this.#marks = { places: [...places], frame };
    const shown = this.#surfaceIsRest && frame === 'file' ? places.map((place) => transformPoint(this.#app.placement, place))
      : !this.#surfaceIsRest && frame === 'rest' ? places.map((place) => untransformPoint(this.#app.placement, place)) : places;
    this.#surface.markPlaces(shown as Vec[], WARNING_COLOR);
    if (places.length > 0 && this.view !== 'model') void this.show('model');
    this.viewer.invalidate();
  }

  /** A click on the part lays that face down; then `done`. Null ends it. */
  setLaying(done: (() => void) | null): void {
    this.#laying = done;
    if (done && this.view !== 'model') void this.show('model');
    this.#cursor();
  }

  /** The load editor has opened, closed or changed. */
  loadsChanged(): void {
    if (this.#loads.active() && this.view !== 'model') void this.show('model');
    this.#paintSurface();
    this.#placeHandles();
    this.#cursor();
  }

  #cursor(): void {
    const picking = this.#laying !== null || (this.view === 'model' && this.#loads.active() !== null);
    this.viewer.canvas.parentElement?.classList.toggle('picking', picking);
    this.viewer.controls.enableRotate = !(this.#loads.active() && this.#loads.tool() !== 'pick' && this.view === 'model');
  }

  #regionShape(): SurfaceShape | null {
    const surface = this.#shownSurface;
    if (!surface) return null;
    this.#shape ??= { positions: surface.positions, indices: surface.indices, neighbors: triangleNeighbors(surface.indices, surface.positions.length / 3) };
    return this.#shape;
  }

  #facesOf(region: LoadRegion, shape: SurfaceShape): Set<number> {
    const all = new Set<number>();
    for (const patch of region.patches) {
      let faces = this.#patchFaces.get(patch);
      if (!faces) this.#patchFaces.set(patch, (faces = facesOf(shape, this.#patchHere(patch))));
      for (const face of faces) all.add(face);
    }
    return all;
  }

  /** Patches are in the file's frame; the surface may be in the rest frame. */
  #patchHere(patch: Patch): Patch {
    if (!this.#surfaceIsRest) return patch;
    const m = this.#app.placement;
    return patch.kind === 'faces'
      ? { ...patch, point: transformPoint(m, patch.point) }
      : { ...patch, center: transformPoint(m, patch.center), radius: patch.radius * scaleOf(m) };
  }

  #paintSurface(): void {
    if (this.view !== 'model') return;
    const { loads } = this.#app.settings;
    const colors = new Map<number, Rgb>();
    const shape = loads.regions.length > 0 ? this.#regionShape() : null;
    for (const arrow of [...this.#forces.children] as THREE.ArrowHelper[]) {
      arrow.dispose();
      this.#forces.remove(arrow);
    }
    const handles = new Set<number>();
    if (shape) {
      // The one that is worked on covers the others.
      const active = this.#loads.active()?.id;
      for (const region of [...loads.regions].sort((a, b) => Number(a.id === active) - Number(b.id === active))) {
        const color = regionColor(loads, region);
        const faces = this.#facesOf(region, shape);
        for (const face of faces) colors.set(face, color);
        if (region.kind === 'force' && faces.size > 0) {
          this.#addArrow(region, middleOf(shape, faces, this.#surfaceIsRest ? null : this.#app.placement), color);
          handles.add(region.id);
        }
      }
    }
    for (const [id, handle] of this.#handles) if (!handles.has(id)) { handle.remove(); this.#handles.delete(id); }
    this.#surface.paint(colors);
    this.#legend(loads.regions.length > 0 ? { title: 'Regions', keys: loads.regions.map((region) => ({ text: region.name, color: regionColor(loads, region) })) } : null);
    this.viewer.invalidate();
  }

  // Arrows are as long as a fifth of the part for the largest force.
  #arrowScale(): number {
    const { min, max } = this.viewer.box;
    const size = Math.hypot(max[0] - min[0], max[1] - min[1], max[2] - min[2]);
    const largest = Math.max(1e-9, ...this.#app.settings.loads.regions.map((region) => (region.kind === 'force' ? Math.hypot(...region.force) : 0)));
    return (0.22 * size) / largest;
  }

  #addArrow(region: LoadRegion, origin: THREE.Vector3, color: Rgb): void {
    const force = new THREE.Vector3(...region.force);
    const length = Math.max(1e-6, force.length() * this.#arrowScale());
    const arrow = new THREE.ArrowHelper(force.clone().normalize(), origin, length, new THREE.Color(...(color.map((c) => c / 255) as Rgb)).getHex(), 0.25 * length, 0.12 * length);
    // Forces mostly point into the part: they are seen through it.
    for (const part of [arrow.line, arrow.cone]) {
      (part.material as THREE.Material).depthTest = false;
      part.renderOrder = 7;
    }
    arrow.userData = { id: region.id, tip: origin.clone().addScaledVector(force, this.#arrowScale()), origin };
    this.#forces.add(arrow);
    if (!this.#handles.has(region.id)) this.#handles.set(region.id, this.#makeHandle(region.id));
  }

  /** The tip of a force's arrow: dragged in the plane that faces the camera. */
  #makeHandle(id: number): HTMLElement {
    const handle = h('button', { class: 'handle', type: 'button', 'aria-label': 'Tip of the force arrow: drag to aim', onpointerdown: (event: PointerEvent) => {
      handle.setPointerCapture(event.pointerId);
    }, onpointermove: (event: PointerEvent) => {
      if (!handle.hasPointerCapture(event.pointerId)) return;
      const region = this.#app.settings.loads.regions.find((one) => one.id === id);
      const arrow = this.#forces.children.find((one) => one.userData.id === id);
      if (!region || !arrow) return;
      const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(this.viewer.camera.getWorldDirection(new THREE.Vector3()), arrow.userData.tip as THREE.Vector3);
      const hit = this.viewer.rayAt(event).ray.intersectPlane(plane, new THREE.Vector3());
      if (!hit) return;
      // The direction follows the pointer; the force stays as large as it was.
      const direction = hit.sub(arrow.userData.origin as THREE.Vector3).normalize().multiplyScalar(Math.hypot(...region.force));
      const force = direction.toArray().map((value) => Math.round(value * 10) / 10) as Vec;
      this.#loads.update({ ...region, force }, `force ${id}`);
    }, onpointerup: () => this.#app.history.seal() });
    this.#marksHost.append(handle);
    return handle;
  }

  #placeHandles(): void {
    const visible = this.view === 'model' && this.#loads.active() !== null;
    this.#forces.visible = this.view === 'model';
    for (const arrow of this.#forces.children) {
      const handle = this.#handles.get(arrow.userData.id as number);
      const at = visible && this.viewer.project(arrow.userData.tip as THREE.Vector3);
      if (!handle) continue;
      handle.hidden = !at;
      if (at) handle.style.transform = `translate(${at.x.toFixed(1)}px, ${at.y.toFixed(1)}px)`;
    }
  }

  #pointer(host: HTMLElement): void {
    let down: { x: number; y: number } | null = null;
    let painting = false;
    host.addEventListener('pointerdown', (event) => {
      down = { x: event.clientX, y: event.clientY };
      painting = event.button === 0 && this.view === 'model' && this.#laying === null && this.#loads.active() !== null && this.#loads.tool() !== 'pick';
      if (painting) this.#dab(event);
    });
    host.addEventListener('pointermove', (event) => { if (painting && event.buttons & 1) this.#dab(event); });
    host.addEventListener('pointerup', (event) => {
      const click = down !== null && Math.hypot(event.clientX - down.x, event.clientY - down.y) < 5 && event.button === 0;
      if (painting) this.#app.history.seal();
      else if (click) this.#click(event);
      painting = false;
      down = null;
    });
  }

  #click(event: PointerEvent): void {
    const caster = this.viewer.rayAt(event);
    if (this.view === 'model') {
      const hit = this.#surface.pick(caster);
      const active = this.#loads.active();
      if (hit && this.#laying) this.#layDown(hit.normal);
      else if (hit && active) this.#loads.update({ ...active, patches: [...active.patches, { kind: 'faces', point: this.#toFile(hit.point), angle: this.#loads.angle() }] });
      return;
    }
    if (this.view === 'layers' || this.view === 'paths') this.#describePoint(caster);
  }

  #layDown(normal: THREE.Vector3): void {
    this.#app.setParams({ 'input.rotate': formatRotation(layOnPlate(this.#app.rotation(), normal.toArray() as Vec)) });
    const done = this.#laying;
    this.setLaying(null);
    done?.();
  }

  #toFile(point: THREE.Vector3): Vec {
    return untransformPoint(this.#app.placement, point.toArray() as Vec);
  }

  #dab(event: PointerEvent): void {
    const active = this.#loads.active(), hit = this.#surface.pick(this.viewer.rayAt(event));
    if (!active || !hit) return;
    const { min, max } = this.viewer.box;
    const radius = (this.#loads.brush() * Math.hypot(max[0] - min[0], max[1] - min[1], max[2] - min[2])) / scaleOf(this.#app.placement);
    const center = this.#toFile(hit.point);
    const away = (point: Vec): number => Math.hypot(point[0] - center[0], point[1] - center[1], point[2] - center[2]);
    if (this.#loads.tool() === 'erase') {
      const patches = active.patches.filter((patch) => away(patch.kind === 'faces' ? patch.point : patch.center) > radius * (patch.kind === 'faces' ? 2 : 1));
      if (patches.length < active.patches.length) this.#loads.update({ ...active, patches }, `paint ${active.id}`);
      return;
    }
    // Dabs that hardly differ from one that is there add nothing.
    if (active.patches.some((patch) => patch.kind === 'sphere' && away(patch.center) < 0.35 * radius)) return;
    this.#loads.update({ ...active, patches: [...active.patches, { kind: 'sphere', center, radius }] }, `paint ${active.id}`);
  }

  // --- what is under the pointer

  #describePoint(caster: THREE.Raycaster): void {
    const layers = this.#layerData;
    const hit = this.#layers.pick(caster);
    this.#pin.visible = hit !== null;
    if (!hit || !layers) {
      replace(this.#infoHost);
      this.viewer.invalidate();
      return;
    }
    this.#pin.position.copy(hit.point);
    const facts: [string, string][] = [
      ['Layer', `${layers.isosurfaces[hit.component]! + 1}${layers.partial[hit.component] ? ', partial' : ''}`], ['Piece', `${hit.component + 1} of ${layers.count}`],
      ['Thickness', `${number(hit.thickness)} mm`], ['Tilt', `${number(hit.tilt)}°`], ['Place', hit.point.toArray().map((value) => value.toFixed(1)).join(', ') + ' mm'],
    ];
    const waypoint = this.view === 'paths' ? this.#nearestWaypoint(hit.component, hit.point) : null;
    const w = this.#waypoints;
    if (waypoint !== null && w) {
      facts.push(['Path', `${w.paths[waypoint]! + 1}, ${['wall', 'infill', 'gap fill'][w.kinds[waypoint]!] ?? ''}`], ['Bead', `${number(w.widths[waypoint]!)} × ${number(w.heights[waypoint]!)} mm`], ['Speed', `${number(w.speeds[waypoint]!)} mm/s`]);
      if (this.#motion && !this.#display.planar) facts.push(['Printed after', printTime(this.#motion.times[waypoint] ?? 0)]);
    }
    replace(this.#infoHost, h('dl', { class: 'facts' }, ...facts.flatMap(([key, value]) => [h('dt', {}, key), h('dd', {}, value)])));
    this.viewer.invalidate();
  }

  #nearestWaypoint(component: number, point: THREE.Vector3): number | null {
    const w = this.#waypoints, layers = this.#layerData;
    if (!w || !layers) return null;
    const begin = componentBegins(w, layers.count);
    let best: number | null = null, least = Infinity;
    for (let i = begin[component]!; i < begin[component + 1]!; ++i) {
      const d = (w.positions[3 * i]! - point.x) ** 2 + (w.positions[3 * i + 1]! - point.y) ** 2 + (w.positions[3 * i + 2]! - point.z) ** 2;
      if (d < least && !w.travels[i]) [best, least] = [i, d];
    }
    return best;
  }

  // --- for keys and buttons

  look(direction: Direction): void {
    this.viewer.look(direction);
  }
  step(layers: number): void {
    this.#timeline.step(layers);
  }
  togglePlay(): void {
    if (this.view === 'paths') this.#timeline.toggle();
  }
  showNext(): readonly ViewName[] {
    return VIEWS.filter(({ stage }) => stage === '' || this.#app.has(stage as never)).map((view) => view.value);
  }
}

/** Points that are seen through the part. */
function marker(): THREE.Points {
  const points = new THREE.Points(
    new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute([0, 0, 0], 3)),
    new THREE.PointsMaterial({ color: 0xe0453a, size: 9, sizeAttenuation: false, depthTest: false }),
  );
  points.visible = false;
  points.renderOrder = 6;
  points.frustumCulled = false;
  return points;
}

const begins = new WeakMap<WaypointArrays, Uint32Array>();
/** The first waypoint of each component, and the end of the last. */
function componentBegins(waypoints: WaypointArrays, count: number): Uint32Array {
  let found = begins.get(waypoints);
  if (!found) {
    found = new Uint32Array(count + 1);
    for (const c of waypoints.components) found[c + 1]!++;
    for (let c = 0; c < count; ++c) found[c + 1]! += found[c]!;
    begins.set(waypoints, found);
  }
  return found;
}

function rangeOfLayers(layers: LayerArrays, from: number, to: number): string {
  if (to <= from) return 'nothing';
  const first = layers.isosurfaces[from]! + 1, last = layers.isosurfaces[to - 1]! + 1;
  return first === last ? `layer ${first}` : `layers ${Math.min(first, last)}–${Math.max(first, last)}`;
}

function tiltOf(directions: ArrayLike<number>, count: number): Float32Array {
  return Float32Array.from({ length: count }, (_, i) => (Math.acos(Math.min(1, Math.max(-1, directions[3 * i + 2]!))) * 180) / Math.PI);
}

function printedOnly(values: ArrayLike<number>, travels: Uint8Array): Float32Array {
  return Float32Array.from({ length: values.length }, (_, i) => (travels[i] ? NaN : values[i]!)).filter((value) => !Number.isNaN(value));
}

function thicknessRange(app: App): [number, number] {
  const nozzle = Number(app.param('nozzle.diameter')) || 1;
  return [Number(app.param('layers.min_thickness')) || 0.4 * nozzle, Number(app.param('layers.max_thickness')) || nozzle];
}

function middleOf(shape: SurfaceShape, faces: Set<number>, matrix: ArrayLike<number> | null): THREE.Vector3 {
  const middle = new THREE.Vector3();
  for (const face of faces) {
    for (let k = 0; k < 3; ++k) {
      const v = 3 * shape.indices[3 * face + k]!;
      middle.x += shape.positions[v]!;
      middle.y += shape.positions[v + 1]!;
      middle.z += shape.positions[v + 2]!;
    }
  }
  middle.divideScalar(3 * faces.size);
  return matrix ? new THREE.Vector3(...transformPoint(matrix, middle.toArray() as Vec)) : middle;
}


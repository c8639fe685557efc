// Canvas, camera, light and plate. Draws only when something has changed.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

export interface Box {
  min: [number, number, number];
  max: [number, number, number];
}

export interface FrameFigures {
  frames: number;
  lastMs: number;
  drawCalls: number;
  triangles: number;
}

const DIRECTIONS: Record<string, [number, number, number]> = {
  iso: [0.62, -1, 0.55], front: [0, -1, 0.02], back: [0, 1, 0.02], left: [-1, 0, 0.02], right: [1, 0, 0.02], top: [0, -0.001, 1], below: [0.4, -0.8, -0.6],
};
export type Direction = keyof typeof DIRECTIONS;

export class Viewer {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(32, 1, 0.1, 1e5);
  readonly controls: OrbitControls;
  readonly figures: FrameFigures = { frames: 0, lastMs: 0, drawCalls: 0, triangles: 0 };
  /** Called before each frame. */
  onFrame: (() => void) | null = null;
  #renderer: THREE.WebGLRenderer;
  #host: HTMLElement;
  #asked = 0;
  #plate = new THREE.Group();
  #axesScene = new THREE.Scene();
  #axesCamera = new THREE.OrthographicCamera(-1.3, 1.3, 1.3, -1.3, -2, 2);
  #light = new THREE.DirectionalLight(0xffffff, 2.0);
  #fill = new THREE.DirectionalLight(0xffffff, 0.55);
  #ambient = new THREE.HemisphereLight(0xffffff, 0x8a8f98, 1.15);
  #box: Box = { min: [-40, -40, 0], max: [40, 40, 60] };
  #plateColors = { line: new THREE.Color(0xc9ced6), strong: new THREE.Color(0xaab1bc) };

  constructor(host: HTMLElement) {
    this.#host = host;
    this.#renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, powerPreference: 'high-performance' });
    this.#renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.#renderer.info.autoReset = true;
    host.append(this.#renderer.domElement);
    const canvas = this.#renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', '3D view of the part. Drag to turn, right drag to move, wheel to zoom.');
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.invalidate());
    this.#light.position.set(-0.6, -1, 1.6);
    this.#fill.position.set(1, 0.8, 0.4);
    this.camera.add(this.#light, this.#fill);
    this.#axesScene.add(makeAxes());
    this.scene.add(this.camera, this.#ambient, this.#plate);
    canvas.addEventListener('webglcontextrestored', () => this.invalidate());
    new ResizeObserver(() => this.#resize()).observe(host);
    this.#resize();
    this.show(this.#box);
  }

  get canvas(): HTMLCanvasElement {
    return this.#renderer.domElement;
  }
  get box(): Box {
    return this.#box;
  }

  /** Draws at the next frame. */
  invalidate(): void {
    if (this.#asked) return;
    this.#asked = requestAnimationFrame(() => {
      this.#asked = 0;
      this.draw();
    });
  }

  draw(): void {
    const begin = performance.now();
    this.onFrame?.();
    this.#renderer.autoClear = true;
    this.#renderer.render(this.scene, this.camera);
    const { calls, triangles } = this.#renderer.info.render;
    this.#drawAxes();
    this.figures.frames++;
    this.figures.drawCalls = calls + 1;
    this.figures.triangles = triangles;
    this.figures.lastMs = performance.now() - begin;
  }

  /** A picture of what is shown now, as PNG. */
  async picture(): Promise<Blob> {
    this.draw();
    return new Promise((resolve, reject) => {
      this.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error('The picture could not be made.'))), 'image/png');
    });
  }

  /** Colours of background and plate from the page's style. */
  applyTheme(): void {
    const style = getComputedStyle(document.documentElement);
    const color = (name: string): THREE.Color => new THREE.Color(style.getPropertyValue(name).trim());
    this.scene.background = color('--scene');
    this.#plateColors = { line: color('--plate-line'), strong: color('--plate-strong') };
    this.#makePlate();
    this.invalidate();
  }

  /** The space that the part takes: plate and camera follow. */
  show(box: Box, direction?: Direction): void {
    this.#box = box;
    this.#makePlate();
    this.look(direction ?? 'iso');
  }

  /** The plate under another box; the camera stays. */
  setBox(box: Box): void {
    this.#box = box;
    this.#makePlate();
    this.invalidate();
  }

  look(direction: Direction): void {
    const { min, max } = this.#box;
    const center = new THREE.Vector3(...min).add(new THREE.Vector3(...max)).multiplyScalar(0.5);
    const radius = Math.max(1e-3, 0.5 * new THREE.Vector3(...max).distanceTo(new THREE.Vector3(...min)));
    const half = Math.min(this.camera.fov / 2, (Math.atan(Math.tan((this.camera.fov * Math.PI) / 360) * this.camera.aspect) * 180) / Math.PI);
    const distance = (1.08 * radius) / Math.sin((half * Math.PI) / 180);
    this.camera.position.copy(center).addScaledVector(new THREE.Vector3(...DIRECTIONS[direction]!).normalize(), distance);
    this.camera.near = radius / 100;
    this.camera.far = distance + 60 * radius;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(center);
    this.controls.minDistance = radius / 50;
    this.controls.maxDistance = 30 * radius;
    this.controls.update();
    this.invalidate();
  }

  /** The ray under a pointer event. */
  rayAt(event: { clientX: number; clientY: number }): THREE.Raycaster {
    const bounds = this.canvas.getBoundingClientRect();
    const pointer = new THREE.Vector2(
      ((event.clientX - bounds.left) / bounds.width) * 2 - 1, 1 - ((event.clientY - bounds.top) / bounds.height) * 2,
    );
    const caster = new THREE.Raycaster();
    caster.setFromCamera(pointer, this.camera);
    return caster;
  }

  /** Where a point of the scene is on the page, in pixels of the host; null behind the camera. */
  project(point: THREE.Vector3): { x: number; y: number } | null {
    const p = point.clone().project(this.camera);
    if (p.z > 1) return null;
    return { x: ((p.x + 1) / 2) * this.#host.clientWidth, y: ((1 - p.y) / 2) * this.#host.clientHeight };
  }

  #resize(): void {
    const width = Math.max(1, this.#host.clientWidth), height = Math.max(1, this.#host.clientHeight);
    this.#renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  #makePlate(): void {
    for (const child of [...this.#plate.children] as THREE.LineSegments[]) {
      child.geometry.dispose();
      (child.material as THREE.Material).dispose();
      this.#plate.remove(child);
    }
    const { min, max } = this.#box;
    const size = Math.max(max[0] - min[0], max[1] - min[1], 1e-3);
    const step = 10 ** Math.ceil(Math.log10(size / 25));
    const low = [0, 1].map((k) => Math.floor((min[k]! - 0.35 * size) / step) * step);
    const high = [0, 1].map((k) => Math.ceil((max[k]! + 0.35 * size) / step) * step);
    const fine: number[] = [], strong: number[] = [];
    for (let axis = 0; axis < 2; ++axis) {
      const other = 1 - axis;
      for (let i = Math.round(low[axis]! / step); i <= Math.round(high[axis]! / step); ++i) {
        const lines = i % 10 === 0 ? strong : fine;
        const a = [0, 0, 0], b = [0, 0, 0];
        a[axis] = b[axis] = i * step;
        a[other] = low[other]!;
        b[other] = high[other]!;
        lines.push(...a, ...b);
      }
    }
    const sink = -2e-3 * size;
    for (const [points, color] of [[fine, this.#plateColors.line], [strong, this.#plateColors.strong]] as const) {
      const geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute(points, 3));
      const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color }));
      lines.position.z = sink;
      this.#plate.add(lines);
    }
  }

  /** x red, y green, z blue in the lower left corner. */
  #drawAxes(): void {
    const size = 64;
    this.#axesCamera.quaternion.copy(this.camera.quaternion);
    this.#renderer.autoClear = false;
    this.#renderer.clearDepth();
    this.#renderer.setViewport(8, 92, size, size);  // above the timeline
    this.#renderer.render(this.#axesScene, this.#axesCamera);
    this.#renderer.setViewport(0, 0, this.#host.clientWidth || 1, this.#host.clientHeight || 1);
  }
}

function makeAxes(): THREE.LineSegments {
  const colors = [0xd24b43, 0x4f9d4a, 0x4077c9].flatMap((value) => {
    const color = new THREE.Color(value);
    return [...color.toArray(), ...color.toArray()];
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute([0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1], 3));
  geometry.setAttribute('color', new THREE.Float32BufferAttribute(colors, 3));
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ vertexColors: true }));
}

/** The box of packed points; null of none. */
export function boxOf(positions: ArrayLike<number>, matrix?: ArrayLike<number>): Box | null {
  if (positions.length < 3) return null;
  const min: Box['min'] = [Infinity, Infinity, Infinity], max: Box['max'] = [-Infinity, -Infinity, -Infinity];
  const m = matrix ?? [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  for (let v = 0; v + 2 < positions.length; v += 3) {
    for (let row = 0; row < 3; ++row) {
      const value = m[row]! * positions[v]! + m[4 + row]! * positions[v + 1]! + m[8 + row]! * positions[v + 2]! + m[12 + row]!;
      if (value < min[row]!) min[row] = value;
      if (value > max[row]!) max[row] = value;
    }
  }
  return { min, max };
}

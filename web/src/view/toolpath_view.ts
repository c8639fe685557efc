// Toolpaths as beads: a ribbon of two triangles for each waypoint that turns to the camera and is shaded as an elliptic
// tube. One draw call for all beads, one for travels; a range of waypoints is a draw range, nothing is rebuilt. Waypoints
// lie in textures that the vertex shader reads: instances of so few corners are slow, above all without a GPU.
import * as THREE from 'three';
import type { WaypointArrays } from '../../../wasm/index.js';
import type { Rgb } from '../color_maps.ts';
import { TRAVEL_COLOR } from '../color_maps.ts';

const ROW = 1024;  // waypoints in a row of the textures

export class ToolpathView {
  readonly group = new THREE.Group();
  #waypoints: WaypointArrays | null = null;
  #beads: THREE.Mesh | null = null;
  #travels: THREE.LineSegments | null = null;
  /** Travels before each waypoint: #W+1. */
  #travelCount = new Uint32Array(1);
  #colors: THREE.DataTexture | null = null;
  #textures: THREE.DataTexture[] = [];
  #nozzle = makeNozzle();
  #range: [number, number] = [0, 0];

  constructor() {
    this.group.add(this.#nozzle);
    this.#nozzle.visible = false;
  }

  set(waypoints: WaypointArrays, nozzleDiameter: number): void {
    this.clear();
    this.#waypoints = waypoints;
    const count = waypoints.count, rows = Math.max(1, Math.ceil(count / ROW));
    const packed = new Float32Array(8 * ROW * rows);  // position and width, normal and height
    for (let w = 0; w < count; ++w) {
      for (let k = 0; k < 3; ++k) {
        packed[8 * w + k] = waypoints.positions[3 * w + k]!;
        packed[8 * w + 4 + k] = waypoints.normals[3 * w + k]!;
      }
      packed[8 * w + 3] = waypoints.widths[w]!;
      packed[8 * w + 7] = waypoints.heights[w]!;
    }
    const shape = new THREE.DataTexture(packed, 2 * ROW, rows, THREE.RGBAFormat, THREE.FloatType);
    shape.needsUpdate = true;
    this.#colors = new THREE.DataTexture(new Uint8Array(4 * ROW * rows), ROW, rows);
    this.#textures = [shape, this.#colors];
    // Four corners for each waypoint but the first: of the way that leads to it. The last comes first: what lies on top
    // is drawn before what it hides.
    const corners = new Uint32Array(6 * Math.max(0, count - 1));
    for (let w = 1; w < count; ++w) corners.set([4 * w, 4 * w + 1, 4 * w + 2, 4 * w, 4 * w + 2, 4 * w + 3], 6 * (count - 1 - w));
    const geometry = new THREE.BufferGeometry().setIndex(new THREE.BufferAttribute(corners, 1));
    this.#beads = new THREE.Mesh(geometry, beadMaterial(shape, this.#colors));
    this.#beads.frustumCulled = false;
    this.group.add(this.#beads);
    this.#makeTravels(waypoints);
    this.#nozzle.scale.setScalar(nozzleDiameter);
    this.setRange(0, count);
  }

  #makeTravels(waypoints: WaypointArrays): void {
    const lines: number[] = [];
    this.#travelCount = new Uint32Array(waypoints.count + 1);
    for (let w = 0; w < waypoints.count; ++w) {
      if (w > 0 && waypoints.travels[w]) {
        for (let k = -3; k < 3; ++k) lines.push(waypoints.positions[3 * w + k]!);
      }
      this.#travelCount[w + 1] = lines.length / 6;
    }
    const geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute(lines, 3));
    const color = new THREE.Color(...TRAVEL_COLOR.map((c) => c / 255) as Rgb);
    this.#travels = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color, transparent: true, opacity: 0.8 }));
    this.#travels.frustumCulled = false;
    this.#travels.visible = false;
    this.group.add(this.#travels);
  }

  /** @param colors rgb bytes of each waypoint: of the way that leads to it */
  paint(colors: Uint8Array): void {
    const waypoints = this.#waypoints, texture = this.#colors;
    if (!waypoints || !texture) return;
    const array = texture.image.data as Uint8Array;
    for (let w = 0; w < waypoints.count; ++w) {
      array[4 * w] = colors[3 * w]!;
      array[4 * w + 1] = colors[3 * w + 1]!;
      array[4 * w + 2] = colors[3 * w + 2]!;
      array[4 * w + 3] = waypoints.travels[w] ? 0 : 255;  // the shader drops what is no bead
    }
    texture.needsUpdate = true;
  }

  /** Shows waypoints from (with) to (without). */
  setRange(from: number, to: number): void {
    if (!this.#beads || !this.#travels) return;
    this.#range = [from, to];
    this.#beads.geometry.setDrawRange(6 * (this.#waypoints!.count - to), 6 * Math.max(0, to - Math.max(1, from)));
    const first = this.#travelCount[from]!, end = this.#travelCount[to]!;
    this.#travels.geometry.setDrawRange(2 * first, 2 * (end - first));
  }

  get range(): [number, number] {
    return this.#range;
  }

  showTravels(visible: boolean): void {
    if (this.#travels) this.#travels.visible = visible;
  }

  /** The nozzle on the way to a waypoint; null takes it away. */
  setNozzle(waypoint: number | null): void {
    const waypoints = this.#waypoints;
    this.#nozzle.visible = waypoint !== null && waypoints !== null && waypoints.count > 0;
    if (!this.#nozzle.visible) return;
    const at = 3 * Math.min(waypoints!.count - 1, Math.max(0, waypoint!));
    this.#nozzle.position.set(waypoints!.positions[at]!, waypoints!.positions[at + 1]!, waypoints!.positions[at + 2]!);
    const normal = new THREE.Vector3(waypoints!.normals[at]!, waypoints!.normals[at + 1]!, waypoints!.normals[at + 2]!);
    this.#nozzle.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), normal.normalize());
  }

  clear(): void {
    for (const object of [this.#beads, this.#travels]) {
      if (!object) continue;
      object.geometry.dispose();
      (object.material as THREE.Material).dispose();
      this.group.remove(object);
    }
    for (const texture of this.#textures) texture.dispose();
    this.#textures = [];
    this.#colors = null;
    this.#beads = this.#travels = null;
    this.#waypoints = null;
    this.#nozzle.visible = false;
  }
}

/** Tip at the origin, pointing down; sizes in nozzle diameters. */
function makeNozzle(): THREE.Mesh {
  const profile = [[0, 0], [0.6, 0], [2, 4], [2, 6], [1.4, 6.1], [1.4, 9.5], [0, 9.5]].map(([x, y]) => new THREE.Vector2(x, y));
  const geometry = new THREE.LatheGeometry(profile, 24).rotateX(Math.PI / 2);
  return new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ color: 0xc9a227, metalness: 0.35, roughness: 0.45, side: THREE.DoubleSide }));
}

function beadMaterial(shape: THREE.Texture, colors: THREE.Texture): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    uniforms: { shape: { value: shape }, colors: { value: colors } },
    side: THREE.DoubleSide,
    vertexShader: `
      uniform highp sampler2D shape;
      uniform lowp sampler2D colors;
      varying vec3 vColor, vView, vSide, vOut;
      varying float vAcross;
      vec4 part(int w, int which) { return texelFetch(shape, ivec2(2 * (w % ${ROW}) + which, w / ${ROW}), 0); }
      void main() {
        int w = gl_VertexID >> 2, corner = gl_VertexID & 3;
        vec4 color = texelFetch(colors, ivec2(w % ${ROW}, w / ${ROW}), 0);
        if (color.a == 0.0) { gl_Position = vec4(2.0, 2.0, 2.0, 0.0); return; }
        // Along the segment, across it.
        vec2 place = vec2(corner == 1 || corner == 2 ? 1.0 : 0.0, corner >= 2 ? 1.0 : -1.0);
        vec4 start = part(w - 1, 0), end = part(w, 0), normal = part(w, 1);
        vec3 from = start.xyz, to = end.xyz, normalFrom = normal.xyz;
        vec2 size = vec2(end.w, normal.w);
        vec3 a = (modelViewMatrix * vec4(from, 1.0)).xyz, b = (modelViewMatrix * vec4(to, 1.0)).xyz;
        vec3 up = normalize(mat3(modelViewMatrix) * normalFrom);
        float span = length(b - a);
        vec3 along = span > 0.0 ? (b - a) / span : vec3(1.0, 0.0, 0.0);
        vec3 wide = normalize(cross(along, up));
        up = cross(wide, along);
        // The waypoint is the nozzle's tip, on top of the bead.
        vec3 p = mix(a, b, place.x) - 0.5 * size.y * up + (place.x - 0.5) * 0.3 * size.x * along;
        vec3 toEye = normalize(-p);
        vec3 side = normalize(cross(along, toEye) + 1e-6 * wide);
        // Half the width of the ellipse's outline seen from here.
        float reach = length(vec2(0.5 * size.x * dot(side, wide), 0.5 * size.y * dot(side, up)));
        p += place.y * reach * side;
        vColor = color.rgb;
        vAcross = place.y;
        vSide = side;
        vOut = normalize(cross(side, along) * sign(dot(cross(side, along), toEye)));
        vView = p;
        gl_Position = projectionMatrix * vec4(p, 1.0);
      }`,
    fragmentShader: `
      varying vec3 vColor, vView, vSide, vOut;
      varying float vAcross;
      void main() {
        float across = clamp(vAcross, -0.98, 0.98);
        vec3 n = normalize(across * vSide + sqrt(1.0 - across * across) * vOut);
        float light = 0.42 + 0.5 * max(0.0, dot(n, normalize(vec3(-0.35, 0.65, 0.75)))) + 0.14 * max(0.0, dot(n, normalize(vec3(0.8, 0.1, 0.3))));
        gl_FragColor = vec4(vColor * light, 1.0);
      }`,
  });
}

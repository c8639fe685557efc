// The part's surface as a file or the stage `mesh` gives it: shown, marked, picked.
import * as THREE from 'three';
import { MeshBVH } from 'three-mesh-bvh';
import type { Surface } from '../../../wasm/index.js';
import type { Rgb } from '../color_maps.ts';

export interface FaceHit {
  face: number;
  point: THREE.Vector3;
  /** Outward normal in the scene. */
  normal: THREE.Vector3;
}

const BASE: Rgb = [158, 172, 188];

export class SurfaceView {
  readonly group = new THREE.Group();
  #mesh: THREE.Mesh | null = null;
  #places: THREE.Points | null = null;
  #bvh: MeshBVH | null = null;
  #matrix = new THREE.Matrix4();

  /** @param matrix 4×4, column by column: from the surface's frame to the scene */
  set(surface: Surface, matrix: ArrayLike<number>): void {
    this.clear();
    const geometry = new THREE.BufferGeometry();
    // Corners of their own for each face, so that faces have their own colours and edges stay sharp.
    const corners = new Float32Array(3 * surface.indices.length);
    for (let i = 0; i < surface.indices.length; ++i) {
      const v = 3 * surface.indices[i]!;
      corners[3 * i] = surface.positions[v]!;
      corners[3 * i + 1] = surface.positions[v + 1]!;
      corners[3 * i + 2] = surface.positions[v + 2]!;
    }
    geometry.setAttribute('position', new THREE.BufferAttribute(corners, 3));
    geometry.setAttribute('normal', new THREE.BufferAttribute(creaseNormals(surface, corners), 3));
    geometry.setAttribute('color', new THREE.BufferAttribute(new Uint8Array(corners.length), 3, true));
    this.#mesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({
      vertexColors: true, roughness: 0.75, metalness: 0, side: THREE.DoubleSide,
    }));
    this.#mesh.matrixAutoUpdate = false;
    this.group.add(this.#mesh);
    this.setMatrix(matrix);
    this.paint(new Map());
  }

  setMatrix(matrix: ArrayLike<number>): void {
    this.#matrix.fromArray(Array.from(matrix));
    this.#mesh?.matrix.copy(this.#matrix);
    this.#mesh?.updateMatrixWorld(true);
    if (this.#places) {
      this.#places.matrix.copy(this.#matrix);
      this.#places.updateMatrixWorld(true);
    }
  }

  /** Colours for some faces; the others take the plain one. */
  paint(colors: Map<number, Rgb>): void {
    if (!this.#mesh) return;
    const attribute = this.#mesh.geometry.getAttribute('color') as THREE.BufferAttribute;
    const array = attribute.array as Uint8Array;
    const base = srgbToLinear(BASE);
    for (let i = 0; i < array.length; i += 3) array.set(base, i);
    for (const [face, color] of colors) {
      const linear = srgbToLinear(color);
      for (let k = 0; k < 3; ++k) array.set(linear, 9 * face + 3 * k);
    }
    attribute.needsUpdate = true;
  }

  /** Marks places of the surface's frame. */
  markPlaces(places: readonly (readonly [number, number, number])[], color: Rgb): void {
    if (this.#places) {
      this.#places.geometry.dispose();
      (this.#places.material as THREE.Material).dispose();
      this.group.remove(this.#places);
      this.#places = null;
    }
    if (places.length === 0) return;
    const geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.Float32BufferAttribute(places.flat(), 3));
    const material = new THREE.PointsMaterial({
      color: new THREE.Color(color[0] / 255, color[1] / 255, color[2] / 255), size: 9, sizeAttenuation: false, depthTest: false,
    });
    this.#places = new THREE.Points(geometry, material);
    this.#places.renderOrder = 5;
    this.#places.matrixAutoUpdate = false;
    this.#places.matrix.copy(this.#matrix);
    this.group.add(this.#places);
  }

  pick(caster: THREE.Raycaster): FaceHit | null {
    const mesh = this.#mesh;
    if (!mesh) return null;
    this.#bvh ??= new MeshBVH(mesh.geometry, { indirect: true });
    const ray = caster.ray.clone().applyMatrix4(mesh.matrixWorld.clone().invert());
    const hit = this.#bvh.raycastFirst(ray, THREE.DoubleSide);
    if (!hit || hit.faceIndex == null || !hit.face) return null;
    return {
      face: hit.faceIndex,
      point: hit.point.clone().applyMatrix4(mesh.matrixWorld),
      normal: hit.face.normal.clone().transformDirection(mesh.matrixWorld),
    };
  }

  clear(): void {
    this.markPlaces([], BASE);
    if (!this.#mesh) return;
    this.#mesh.geometry.dispose();
    (this.#mesh.material as THREE.Material).dispose();
    this.group.remove(this.#mesh);
    this.#mesh = null;
    this.#bvh = null;
  }
}

/** Vertex colours are linear in three.js. */
export function srgbToLinear(color: Rgb): Rgb {
  return color.map((value) => Math.round(255 * SRGB[value]!)) as Rgb;
}

const SRGB = Float64Array.from({ length: 256 }, (_, i) => {
  const c = i / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
});

/** A normal for each corner: smooth across edges below 35°, sharp above. */
function creaseNormals(surface: Surface, corners: Float32Array): Float32Array {
  const faces = surface.indices.length / 3;
  const faceNormals = new Float32Array(3 * faces);  // length = twice the area: large faces count more
  for (let f = 0; f < faces; ++f) {
    const o = 9 * f;
    const ux = corners[o + 3]! - corners[o]!, uy = corners[o + 4]! - corners[o + 1]!, uz = corners[o + 5]! - corners[o + 2]!;
    const vx = corners[o + 6]! - corners[o]!, vy = corners[o + 7]! - corners[o + 1]!, vz = corners[o + 8]! - corners[o + 2]!;
    faceNormals[3 * f] = uy * vz - uz * vy;
    faceNormals[3 * f + 1] = uz * vx - ux * vz;
    faceNormals[3 * f + 2] = ux * vy - uy * vx;
  }
  const vertexCount = surface.positions.length / 3;
  const begin = new Uint32Array(vertexCount + 1);
  for (const v of surface.indices) begin[v + 1]!++;
  for (let v = 0; v < vertexCount; ++v) begin[v + 1]! += begin[v]!;
  const around = new Uint32Array(surface.indices.length), fill = begin.slice(0, vertexCount);
  surface.indices.forEach((v, corner) => (around[fill[v]!++] = Math.floor(corner / 3)));
  const normals = new Float32Array(corners.length);
  const limit = Math.cos((35 * Math.PI) / 180);
  for (let corner = 0; corner < surface.indices.length; ++corner) {
    const f = 3 * Math.floor(corner / 3), v = surface.indices[corner]!;
    const fx = faceNormals[f]!, fy = faceNormals[f + 1]!, fz = faceNormals[f + 2]!;
    const own = Math.hypot(fx, fy, fz) || 1;
    let x = 0, y = 0, z = 0;
    for (let i = begin[v]!; i < begin[v + 1]!; ++i) {
      const g = 3 * around[i]!;
      const gx = faceNormals[g]!, gy = faceNormals[g + 1]!, gz = faceNormals[g + 2]!;
      const length = Math.hypot(gx, gy, gz) || 1;
      if (fx * gx + fy * gy + fz * gz >= limit * own * length) {
        x += gx;
        y += gy;
        z += gz;
      }
    }
    const length = Math.hypot(x, y, z) || 1;
    normals[3 * corner] = x / length;
    normals[3 * corner + 1] = y / length;
    normals[3 * corner + 2] = z / length;
  }
  return normals;
}

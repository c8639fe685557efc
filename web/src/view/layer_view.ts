// All layers in one mesh and one draw call: a range of layers is a draw range, exploding is done by the vertex shader.
import * as THREE from 'three';
import { MeshBVH } from 'three-mesh-bvh';
import type { LayerArrays } from '../../../wasm/index.js';
import { srgbToLinear } from './surface_view.ts';
import type { Rgb } from '../color_maps.ts';

export interface LayerHit {
  component: number;
  point: THREE.Vector3;
  thickness: number;
  /** Degrees between layer normal and z. */
  tilt: number;
  normal: THREE.Vector3;
}

export class LayerView {
  readonly group = new THREE.Group();
  #layers: LayerArrays | null = null;
  #mesh: THREE.Mesh | null = null;
  #bvh: MeshBVH | null = null;
  #range: [number, number] = [0, 0];
  #explode = { value: 0 };

  set(layers: LayerArrays): void {
    this.clear();
    this.#layers = layers;
    const geometry = new THREE.BufferGeometry();
    const positions = layers.positions as Float32Array, normals = layers.normals as Float32Array;
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3));
    const level = new Float32Array(positions.length / 3);
    for (let c = 0; c < layers.count; ++c) level.fill(layers.isosurfaces[c]!, layers.vertexOffsets[c], layers.vertexOffsets[c + 1]);
    geometry.setAttribute('level', new THREE.BufferAttribute(level, 1));
    geometry.setAttribute('color', new THREE.BufferAttribute(new Uint8Array(positions.length), 3, true));
    geometry.setIndex(new THREE.BufferAttribute(layers.indices, 1));
    this.#mesh = new THREE.Mesh(geometry, layerMaterial(this.#explode));
    this.#mesh.frustumCulled = false;
    this.group.add(this.#mesh);
    this.setRange(0, layers.count);
  }

  get count(): number {
    return this.#layers?.count ?? 0;
  }

  /** Shows components from (with) to (without). */
  setRange(from: number, to: number): void {
    const layers = this.#layers;
    if (!layers || !this.#mesh) return;
    this.#range = [from, to];
    const first = layers.indexOffsets[from]!;
    this.#mesh.geometry.setDrawRange(first, layers.indexOffsets[to]! - first);
  }

  /** Moves each layer up by so many mm for each one below it. */
  setExplode(distance: number): void {
    this.#explode.value = distance;
  }

  /** @param colors rgb bytes of each vertex */
  paint(colors: Uint8Array): void {
    const attribute = this.#mesh?.geometry.getAttribute('color') as THREE.BufferAttribute | undefined;
    if (!attribute) return;
    const array = attribute.array as Uint8Array;
    for (let i = 0; i < array.length; i += 3) array.set(srgbToLinear([colors[i]!, colors[i + 1]!, colors[i + 2]!] as Rgb), i);
    attribute.needsUpdate = true;
  }

  /** The nearest hit on the layers that are shown. */
  pick(caster: THREE.Raycaster): LayerHit | null {
    const layers = this.#layers, mesh = this.#mesh;
    if (!layers || !mesh || this.#explode.value !== 0) return null;
    if (!this.#bvh) {
      // All of the layers, whatever is drawn now.
      const { start, count } = mesh.geometry.drawRange;
      mesh.geometry.setDrawRange(0, Infinity);
      this.#bvh = new MeshBVH(mesh.geometry, { indirect: true });
      mesh.geometry.setDrawRange(start, count);
    }
    const first = layers.indexOffsets[this.#range[0]]! / 3, end = layers.indexOffsets[this.#range[1]]! / 3;
    let best: { distance: number; point: THREE.Vector3; face: number } | null = null;
    for (const hit of this.#bvh.raycast(caster.ray, THREE.DoubleSide)) {
      const face = hit.faceIndex ?? -1;
      if (face >= first && face < end && (!best || hit.distance < best.distance)) best = { distance: hit.distance, point: hit.point, face };
    }
    if (!best) return null;
    return this.#describe(layers, best.face, best.point);
  }

  #describe(layers: LayerArrays, face: number, point: THREE.Vector3): LayerHit {
    const [a, b, c] = [0, 1, 2].map((k) => layers.indices[3 * face + k]!) as [number, number, number];
    const at = (array: ArrayLike<number>, v: number): THREE.Vector3 => new THREE.Vector3(array[3 * v]!, array[3 * v + 1]!, array[3 * v + 2]!);
    const weights = THREE.Triangle.getBarycoord(point, at(layers.positions, a), at(layers.positions, b), at(layers.positions, c), new THREE.Vector3())
      ?? new THREE.Vector3(1, 0, 0);
    const normal = at(layers.normals, a).multiplyScalar(weights.x)
      .addScaledVector(at(layers.normals, b), weights.y).addScaledVector(at(layers.normals, c), weights.z).normalize();
    return {
      component: componentOf(layers.indexOffsets, 3 * face),
      point: point.clone(),
      thickness: layers.thickness[a]! * weights.x + layers.thickness[b]! * weights.y + layers.thickness[c]! * weights.z,
      tilt: (Math.acos(Math.min(1, Math.max(-1, normal.z))) * 180) / Math.PI,
      normal,
    };
  }

  clear(): void {
    if (this.#mesh) {
      this.#mesh.geometry.dispose();
      (this.#mesh.material as THREE.Material).dispose();
      this.group.remove(this.#mesh);
    }
    this.#mesh = null;
    this.#layers = null;
    this.#bvh = null;
  }
}

/** The last offset that is not above the entry. */
export function componentOf(offsets: Uint32Array, entry: number): number {
  let low = 0, high = offsets.length - 2;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (offsets[middle]! <= entry) low = middle;
    else high = middle - 1;
  }
  return low;
}

function layerMaterial(explode: { value: number }): THREE.Material {
  const material = new THREE.MeshStandardMaterial({ vertexColors: true, roughness: 0.7, side: THREE.DoubleSide });
  material.onBeforeCompile = (shader) => {
    shader.uniforms.explode = explode;
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', 'attribute float level;\nuniform float explode;\n#include <common>')
      .replace('#include <begin_vertex>', 'vec3 transformed = position + vec3(0.0, 0.0, explode * level);');
  };
  return material;
}

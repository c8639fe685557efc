// The tet mesh: cut by a plane, coloured by any number a tet or a vertex has, anywhere between rest and deformed shape,
// with arrows for directions. Two draw calls.
import * as THREE from 'three';
import type { TetArrays } from '../../../wasm/index.js';
import { tetCentroids, tetNeighbors, visibleFaces } from '../tet_topology.ts';
import type { Box } from './viewer.ts';
import { srgbToLinear } from './surface_view.ts';
import { LAYER_TONES } from '../color_maps.ts';
import type { Rgb } from '../color_maps.ts';

export interface Cut {
  axis: 0 | 1 | 2;
  /** mm: tets with their centroid on the other side are left out. */
  at: number;
  /** Whether the lower side is kept. */
  below: boolean;
}

/** rgb bytes of each tet or of each vertex; or a number at each vertex whose whole steps are bands of alternating tones. */
export type SolidColors = { per: 'tet' | 'vertex'; rgb: Uint8Array } | { per: 'bands'; level: Float32Array } | null;

const ARROWS = 2600;

export class SolidView {
  readonly group = new THREE.Group();
  #mesh: TetArrays | null = null;
  #deformed: ArrayLike<number> | null = null;
  #directions: ArrayLike<number> | null = null;
  #neighbors: Int32Array | null = null;
  #centroids: (Float32Array | null)[] = [null, null, null];
  #shown: THREE.Mesh | null = null;
  #arrows: THREE.InstancedMesh | null = null;
  #amount = { value: 0 };
  #cut: Cut | null = null;
  #colors: SolidColors = null;
  #showArrows = false;
  #edges = true;

  set(mesh: TetArrays): void {
    this.clear();
    this.#mesh = mesh;
    this.#neighbors = null;
    this.#centroids = [null, null, null];
  }

  get ready(): boolean {
    return this.#mesh !== null;
  }

  setDeformed(positions: ArrayLike<number> | null, directions: ArrayLike<number> | null): void {
    this.#deformed = positions;
    this.#directions = directions;
  }

  /** Between 0 (rest) and 1 (deformed); no geometry is made anew. */
  setAmount(amount: number): void {
    this.#amount.value = amount;
    if (this.#arrows) this.#arrows.visible = this.#showArrows && amount === 0;
  }

  /** What setCut(), setColors() and setArrows() said becomes geometry. */
  update(options: { cut: Cut | null; colors: SolidColors; arrows: boolean; edges: boolean }): void {
    this.#cut = options.cut;
    this.#colors = options.colors;
    this.#showArrows = options.arrows;
    this.#edges = options.edges;
    this.#rebuild();
  }

  #kept(): (tet: number) => boolean {
    const cut = this.#cut, mesh = this.#mesh!;
    if (!cut) return () => true;
    const centroids = (this.#centroids[cut.axis] ??= tetCentroids(mesh, cut.axis));
    return (tet) => centroids[tet]! <= cut.at === cut.below;
  }

  #rebuild(): void {
    const mesh = this.#mesh;
    this.#drop();
    if (!mesh) return;
    this.#neighbors ??= tetNeighbors(mesh.tets, mesh.positions.length / 3);
    const kept = this.#kept();
    const faces = visibleFaces(mesh, this.#neighbors, kept);
    const count = faces.vertices.length;
    const position = new Float32Array(3 * count), target = new Float32Array(3 * count), color = new Uint8Array(3 * count);
    const deformed = this.#deformed ?? mesh.positions;
    for (let i = 0; i < count; ++i) {
      const v = 3 * faces.vertices[i]!;
      for (let k = 0; k < 3; ++k) {
        position[3 * i + k] = mesh.positions[v + k]!;
        target[3 * i + k] = deformed[v + k]!;
      }
    }
    this.#fillColors(faces, color);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(position, 3));
    geometry.setAttribute('deformed', new THREE.BufferAttribute(target, 3));
    geometry.setAttribute('color', new THREE.BufferAttribute(color, 3, true));
    const bands = this.#colors?.per === 'bands' ? this.#colors.level : null;
    if (bands) geometry.setAttribute('level', new THREE.BufferAttribute(Float32Array.from(faces.vertices, (v) => bands[v]!), 1));
    geometry.setAttribute('corner', new THREE.BufferAttribute(Float32Array.from({ length: count }, (_, i) => i % 3), 1));
    this.#shown = new THREE.Mesh(geometry, solidMaterial(this.#amount, this.#edges, bands !== null));
    this.#shown.frustumCulled = false;
    this.group.add(this.#shown);
    if (this.#directions) this.#makeArrows(mesh, this.#directions, kept);
  }

  #fillColors(faces: { vertices: Uint32Array; tets: Uint32Array; firstInner: number }, color: Uint8Array): void {
    const outer = srgbToLinear([158, 172, 188]), inner = srgbToLinear([214, 190, 150]);
    const chosen = this.#colors;
    for (let i = 0; i < faces.vertices.length; ++i) {
      const face = Math.floor(i / 3);
      if (!chosen) {
        color.set(face < faces.firstInner ? outer : inner, 3 * i);
      } else if (chosen.per === 'bands') {
        color.fill(255, 3 * i, 3 * i + 3);
      } else {
        const at = 3 * (chosen.per === 'tet' ? faces.tets[face]! : faces.vertices[i]!);
        color.set(srgbToLinear([chosen.rgb[at]!, chosen.rgb[at + 1]!, chosen.rgb[at + 2]!] as Rgb), 3 * i);
      }
    }
  }

  /** Arrows in some of the tets that are kept, evenly spread over their order, which follows space. */
  #makeArrows(mesh: TetArrays, directions: ArrayLike<number>, kept: (tet: number) => boolean): void {
    const tets: number[] = [];
    for (let t = 0; t < mesh.tets.length / 4; ++t) if (kept(t)) tets.push(t);
    const step = Math.max(1, Math.ceil(tets.length / ARROWS));
    const chosen = tets.filter((_, i) => i % step === 0);
    const box = boxSize(mesh.positions);
    const length = 0.045 * Math.hypot(...box);
    const arrow = arrowGeometry();
    const arrows = new THREE.InstancedMesh(arrow, new THREE.MeshStandardMaterial({ color: 0x1d5fae, roughness: 0.6 }), chosen.length);
    const matrix = new THREE.Matrix4(), turn = new THREE.Quaternion(), up = new THREE.Vector3(0, 0, 1);
    const size = new THREE.Vector3(length, length, length), place = new THREE.Vector3(), direction = new THREE.Vector3();
    chosen.forEach((t, i) => {
      place.set(0, 0, 0);
      for (let k = 0; k < 4; ++k) {
        const v = 3 * mesh.tets[4 * t + k]!;
        place.x += mesh.positions[v]! / 4;
        place.y += mesh.positions[v + 1]! / 4;
        place.z += mesh.positions[v + 2]! / 4;
      }
      direction.set(directions[3 * t]!, directions[3 * t + 1]!, directions[3 * t + 2]!);
      arrows.setMatrixAt(i, matrix.compose(place, turn.setFromUnitVectors(up, direction), size));
    });
    arrows.frustumCulled = false;
    arrows.visible = this.#showArrows && this.#amount.value === 0;
    this.#arrows = arrows;
    this.group.add(arrows);
  }

  #drop(): void {
    for (const object of [this.#shown, this.#arrows]) {
      if (!object) continue;
      object.geometry.dispose();
      (object.material as THREE.Material).dispose();
      this.group.remove(object);
    }
    this.#arrows?.dispose();
    this.#shown = this.#arrows = null;
  }

  clear(): void {
    this.#drop();
    this.#mesh = null;
    this.#deformed = this.#directions = null;
    this.#colors = null;
  }
}

function boxSize(positions: ArrayLike<number>): Box['min'] {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; ++i) {
    low[i % 3] = Math.min(low[i % 3]!, positions[i]!);
    high[i % 3] = Math.max(high[i % 3]!, positions[i]!);
  }
  return [high[0]! - low[0]!, high[1]! - low[1]!, high[2]! - low[2]!];
}

/** A thin arrow of length 1 along z. */
function arrowGeometry(): THREE.BufferGeometry {
  const shaft = new THREE.CylinderGeometry(0.035, 0.035, 0.7, 5, 1, true).rotateX(Math.PI / 2).translate(0, 0, 0.35);
  const head = new THREE.ConeGeometry(0.11, 0.32, 6).rotateX(Math.PI / 2).translate(0, 0, 0.84);
  const parts = [shaft, head].map((part) => part.toNonIndexed());
  const join = (name: string): THREE.BufferAttribute =>
    new THREE.BufferAttribute(Float32Array.from(parts.flatMap((part) => [...part.getAttribute(name).array])), 3);
  return new THREE.BufferGeometry().setAttribute('position', join('position')).setAttribute('normal', join('normal'));
}

/** Flat faces between two shapes, with the edges of the tets drawn in. */
function solidMaterial(amount: { value: number }, edges: boolean, bands: boolean): THREE.Material {
  const material = new THREE.MeshStandardMaterial({ vertexColors: true, roughness: 0.8, flatShading: true, side: THREE.DoubleSide });
  material.onBeforeCompile = (shader) => {
    shader.uniforms.amount = amount;
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', 'attribute vec3 deformed;\nattribute float corner;\nuniform float amount;\nvarying vec3 vCorner;\n#include <common>')
      .replace('#include <begin_vertex>',
        'vec3 transformed = mix(position, deformed, amount);\nvCorner = vec3(corner == 0.0, corner == 1.0, corner == 2.0);');
    if (bands) {
      const tones = LAYER_TONES.map((tone) => `vec3(${srgbToLinear(tone).map((value) => (value / 255).toFixed(4)).join(', ')})`);
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', 'attribute float level;\nvarying float vLevel;\n#include <common>').replace('vCorner =', 'vLevel = level;\nvCorner =');
      shader.fragmentShader = shader.fragmentShader
        .replace('#include <common>', `varying float vLevel;\nconst vec3 TONES[${tones.length}] = vec3[](${tones.join(', ')});\n#include <common>`)
        .replace('#include <color_fragment>', `diffuseColor.rgb *= TONES[int(mod(floor(vLevel), ${tones.length}.0))];\n#include <color_fragment>`);
    }
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', 'varying vec3 vCorner;\n#include <common>')
      .replace('#include <color_fragment>', edges
        ? '#include <color_fragment>\nvec3 wide = fwidth(vCorner);\nvec3 near = smoothstep(vec3(0.0), 1.1 * wide, vCorner);\n' +
          'diffuseColor.rgb *= mix(0.72, 1.0, min(near.x, min(near.y, near.z)));'
        : '#include <color_fragment>');
  };
  material.customProgramCacheKey = () => `solid-${edges}-${bands}`;
  return material;
}

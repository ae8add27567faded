/**
 * Draw lists and their order, without garbage.  three.js empties its lists for each picture,
 * fills them again and copies them to sort them; these keep their entries and arrays, and sort
 * themselves in place by three's own rules.
 */
import type { BufferGeometry, Material, Object3D, Scene, WebGLRenderer } from 'three';

/** Keys of an entry that decide when it is drawn. */
export interface Drawn {
  readonly id: number;
  readonly groupOrder: number;
  readonly renderOrder: number;
  /** Depth, from −1 to 1. */
  readonly z: number;
  readonly material: { readonly id: number };
  /** One material has several programs, for things of several kinds. */
  readonly materialVariant: number;
}

/** Order solid entries by material, so that programs change seldom, then the nearest first. */
export function solidBefore(a: Drawn, b: Drawn): boolean {
  if (a.groupOrder !== b.groupOrder) return a.groupOrder < b.groupOrder;
  if (a.renderOrder !== b.renderOrder) return a.renderOrder < b.renderOrder;
  if (a.material.id !== b.material.id) return a.material.id < b.material.id;
  if (a.materialVariant !== b.materialVariant) return a.materialVariant < b.materialVariant;
  return a.z === b.z ? a.id < b.id : a.z < b.z;
}

/** Order transparent entries, the farthest first. */
export function clearBefore(a: Drawn, b: Drawn): boolean {
  if (a.groupOrder !== b.groupOrder) return a.groupOrder < b.groupOrder;
  if (a.renderOrder !== b.renderOrder) return a.renderOrder < b.renderOrder;
  return a.z === b.z ? a.id < b.id : a.z > b.z;
}

/** Sort by insertion: the lists have some dozens of entries. */
export function sortInPlace<T>(list: T[], before: (a: T, b: T) => boolean): T[] {
  for (let i = 1; i < list.length; i++) {
    const entry = list[i]!;
    let to = i;
    for (; to > 0 && before(entry, list[to - 1]!); to--) list[to] = list[to - 1]!;
    list[to] = entry;
  }
  return list;
}

/** An entry as three.js reads it. */
interface Entry {
  id: number;
  object: Object3D | null;
  geometry: BufferGeometry | null;
  material: Material;
  materialVariant: number;
  groupOrder: number;
  renderOrder: number;
  z: number;
  group: null;
}

/** Things of one kind; after `finish`, `entries` are the entries of this picture. */
class Kept {
  readonly entries: Entry[] = [];
  private readonly pool: Entry[] = [];
  private count = 0;

  begin(): void {
    this.count = 0;
  }

  add(
    object: Object3D,
    geometry: BufferGeometry | null,
    material: Material,
    groupOrder: number,
    z: number,
  ): void {
    let entry = this.pool[this.count];
    if (!entry) {
      // The depth begins as a fraction: V8 boxes a field that begins as an integer.
      entry = { id: 0, object, geometry, material, materialVariant: 0, groupOrder, renderOrder: 0, z: 0.5, group: null }; // prettier-ignore
      this.pool.push(entry);
    }
    this.count += 1;
    entry.id = object.id;
    entry.object = object;
    entry.geometry = geometry;
    entry.material = material;
    entry.materialVariant = 'isInstancedMesh' in object ? 2 : 0;
    entry.groupOrder = groupOrder;
    entry.renderOrder = object.renderOrder;
    entry.z = z;
  }

  finish(): void {
    const { entries, pool, count } = this;
    for (let i = 0; i < count; i++) entries[i] = pool[i]!;
    if (entries.length > count) entries.length = count;
    // Removed pieces must not be kept in memory.
    for (let i = count; i < pool.length && pool[i]!.object; i++) {
      pool[i]!.object = pool[i]!.geometry = null;
    }
  }
}

/** Make a scene's draw lists reuse their entries, as long as the renderer exists. */
export function keepLists(renderer: WebGLRenderer, scene: Scene): void {
  const solid = new Kept();
  const clear = new Kept();
  Object.assign(renderer.renderLists.get(scene, 0), {
    opaque: solid.entries,
    transparent: clear.entries,
    init: () => {
      solid.begin();
      clear.begin();
    },
    push: (
      object: Object3D,
      geometry: BufferGeometry | null,
      material: Material,
      groupOrder: number,
      z: number,
    ) => {
      (material.transparent ? clear : solid).add(object, geometry, material, groupOrder, z);
    },
    finish: () => {
      solid.finish();
      clear.finish();
    },
    sort: () => {
      sortInPlace(solid.entries, solidBefore);
      sortInPlace(clear.entries, clearBefore);
    },
  });
}

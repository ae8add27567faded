/**
 * The order in which things are drawn, without garbage.  three.js calls `Array.sort` on its lists for
 * each picture, which copies them; these sort themselves in place, by three's own rules.
 */
import type { Scene, WebGLRenderer } from 'three';

/** What of an entry of three's lists decides when it is drawn. */
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

/** What is solid: by material, so that programs change seldom, then the nearest first. */
export function solidBefore(a: Drawn, b: Drawn): boolean {
  if (a.groupOrder !== b.groupOrder) return a.groupOrder < b.groupOrder;
  if (a.renderOrder !== b.renderOrder) return a.renderOrder < b.renderOrder;
  if (a.material.id !== b.material.id) return a.material.id < b.material.id;
  if (a.materialVariant !== b.materialVariant) return a.materialVariant < b.materialVariant;
  return a.z === b.z ? a.id < b.id : a.z < b.z;
}

/** What one sees through: the farthest first. */
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

/** Let a scene's lists sort themselves; they are the same ones as long as the renderer lives. */
export function sortWithoutGarbage(renderer: WebGLRenderer, scene: Scene): void {
  const lists = renderer.renderLists.get(scene, 0);
  lists.opaque.sort = function () {
    return sortInPlace(this, solidBefore);
  };
  for (const list of [lists.transparent, lists.transmissive]) {
    list.sort = function () {
      return sortInPlace(this, clearBefore);
    };
  }
}

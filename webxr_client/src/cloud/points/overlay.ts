/** Overlays of labels, shown by a stroke or a run before the server has answered. */

/** Labels shown over the server's own until it answers: a stroke, a tracking run. */
export interface Overlay {
  /** Stored numbers. */
  readonly indices: Uint32Array;
  /** One value for each, or a single one for all. */
  readonly values: Uint16Array;
  /** The edit on its way to the server that it shows, if it does. */
  readonly edit?: string;
}

/** The same overlay with its numbers in order. */
export function sorted(overlay: Overlay): Overlay {
  const { indices } = overlay;
  let last = 0;
  while (last + 1 < indices.length && indices[last]! < indices[last + 1]!) last++;
  if (last + 1 >= indices.length) return overlay;
  // Number and value in one: a sort of numbers needs no comparing function.
  const pairs = Float64Array.from(
    indices,
    (point, i) => point * 65536 + valueAt(overlay, i),
  ).sort();
  return {
    indices: Uint32Array.from(pairs, (pair) => pair / 65536),
    values: Uint16Array.from(pairs, (pair) => pair % 65536),
  };
}

/** Merge two ordered overlays; values of `news` replace values of the same points. */
export function merged(before: Overlay, news: Overlay): Overlay {
  const most = before.indices.length + news.indices.length;
  const indices = new Uint32Array(most);
  const values = new Uint16Array(most);
  let count = 0;
  for (let i = 0, k = 0; i < before.indices.length || k < news.indices.length; count++) {
    const old = before.indices[i] ?? Infinity;
    const fresh = news.indices[k] ?? Infinity;
    indices[count] = Math.min(old, fresh);
    values[count] = fresh <= old ? valueAt(news, k) : valueAt(before, i);
    if (old <= fresh) i++;
    if (fresh <= old) k++;
  }
  return { indices: indices.subarray(0, count), values: values.subarray(0, count) };
}

function valueAt({ values }: Overlay, index: number): number {
  return values[values.length === 1 ? 0 : index]!;
}

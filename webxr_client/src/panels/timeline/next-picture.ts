/** Drawing at most once a picture, with the newest values. */

export interface NextPicture<T> {
  readonly show: (value: T) => void;
  readonly stop: () => void;
}

/**
 * Call `draw` with the newest value at the next picture of the browser. A pending call is not
 * requested again: values that change before every picture would postpone it forever.
 */
export function atNextPicture<T>(draw: (value: T) => void): NextPicture<T> {
  let newest: { readonly value: T } | null = null;
  let request = 0;
  const run = (): void => {
    const { value } = newest!;
    newest = null;
    draw(value);
  };
  return {
    show: (value) => {
      if (!newest) request = requestAnimationFrame(run);
      newest = { value };
    },
    stop: () => {
      cancelAnimationFrame(request);
      newest = null;
    },
  };
}

/** Long lists of which only the rows in sight are drawn. */
import type { RefObject } from 'preact';
import { useLayoutEffect, useRef, useState } from 'preact/hooks';

/** Rows beyond the edges that are drawn too, so that the keyboard gets to them. */
const MORE = 6;
/** Rows that are drawn before the height is known. */
const FIRST_ROWS = 40;

/** The part of a scrolled box that is in sight, in rows from the top of its content. */
export interface Sight {
  readonly first: number;
  readonly last: number;
}

/** Follow the visible part of a box with rows of the height `--row`. */
export function useSight(): [RefObject<HTMLDivElement | null>, Sight] {
  const box = useRef<HTMLDivElement>(null);
  const [sight, setSight] = useState<Sight>({ first: 0, last: FIRST_ROWS });
  useLayoutEffect(() => {
    const own = box.current!;
    const height = parseFloat(getComputedStyle(own).getPropertyValue('--row'));
    const look = (): void => {
      const first = Math.floor(own.scrollTop / height) - MORE;
      const last = Math.ceil((own.scrollTop + own.clientHeight) / height) + MORE;
      setSight((was) => (was.first === first && was.last === last ? was : { first, last }));
    };
    const resized = new ResizeObserver(look);
    resized.observe(own);
    own.addEventListener('scroll', look, { passive: true });
    return () => {
      resized.disconnect();
      own.removeEventListener('scroll', look);
    };
  }, []);
  return [box, sight];
}

/** Rows to draw of `count` that begin `offset` rows below the top: from, until. */
export function inSight({ first, last }: Sight, offset: number, count: number): [number, number] {
  const within = (row: number): number => Math.min(count, Math.max(0, row - offset));
  return [within(first), within(last)];
}

/** The style of a list with rows from `from` of `count`: it is as high as if all were drawn. */
export function listStyle(count: number, from: number): Record<string, string> {
  return { '--rows': String(count), '--from': String(from) };
}

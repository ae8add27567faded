/** The lasso: an outline drawn over the picture, by hand, as a rectangle or corner by corner. */
import { signal } from '@preact/signals';

export type OutlineKind = 'free' | 'rectangle' | 'polygon';

/** Kind of lasso. */
export const outlineKind = signal<OutlineKind>('free');

const KINDS: readonly OutlineKind[] = ['free', 'rectangle', 'polygon'];

/** Draw the next outlines in the next way. */
export function nextOutlineKind(): void {
  outlineKind.value = KINDS[(KINDS.indexOf(outlineKind.peek()) + 1) % KINDS.length]!;
}

const NS = 'http://www.w3.org/2000/svg';
/** A corner every few pixels is as fine as a hand draws. */
const STEP = 3;
/** A click so near to the first corner closes a polygon, pixels. */
const CLOSE = 10;
/** The wire takes 4096 corners. */
const MOST = 4000;

type Place = readonly [number, number];

export class LassoOutline {
  private readonly svg = document.createElementNS(NS, 'svg');
  private readonly line = document.createElementNS(NS, 'polygon');
  private readonly first = document.createElementNS(NS, 'circle');
  private corners: Place[] = [];
  private pointer: Place | null = null;
  private kind: OutlineKind = 'free';
  /** Something of it changed since it was asked. */
  changed = false;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.svg.classList.add('lasso');
    const { style } = this.svg;
    style.position = 'absolute';
    style.inset = '0';
    style.width = '100%';
    style.height = '100%';
    style.pointerEvents = 'none';
    this.svg.append(this.line, this.first);
    this.line.setAttribute('stroke-width', '1.5');
    this.line.setAttribute('stroke-dasharray', '5 4');
    this.line.setAttribute('fill-opacity', '0.12');
    this.first.setAttribute('r', '4');
  }

  /** A polygon waits for its next corner. */
  get open(): boolean {
    return this.kind === 'polygon' && this.corners.length > 0;
  }

  begin(x: number, y: number, color: string, kind = outlineKind.peek()): void {
    this.kind = kind;
    this.corners = [[x, y]];
    this.pointer = null;
    for (const part of [this.line, this.first]) part.setAttribute('stroke', color);
    this.line.setAttribute('fill', color);
    this.first.setAttribute('fill', color);
    this.first.setAttribute('cx', String(x));
    this.first.setAttribute('cy', String(y));
    this.first.style.display = this.kind === 'polygon' ? '' : 'none';
    this.show();
    this.canvas.parentElement?.append(this.svg);
  }

  /** The pointer is here: the outline goes on, or its last corner follows. */
  add(x: number, y: number): void {
    if (this.corners.length === 0) return;
    if (this.kind === 'free') {
      const last = this.corners.at(-1)!;
      if (Math.hypot(x - last[0], y - last[1]) < STEP) return;
      this.corners.push([x, y]);
    } else this.pointer = [x, y];
    this.show();
  }

  /** A click while a polygon is open; true when it closes the polygon. */
  corner(x: number, y: number): boolean {
    const [first] = this.corners;
    const back = first && Math.hypot(x - first[0], y - first[1]) < CLOSE;
    if (back && this.corners.length >= 3) return true;
    this.corners.push([x, y]);
    this.show();
    return false;
  }

  /** Take back the last corner of a polygon; false when none is open. */
  takeBack(): boolean {
    if (!this.open) return false;
    this.corners.pop();
    if (this.corners.length === 0) this.cancel();
    else this.show();
    return true;
  }

  private show(): void {
    this.changed = true;
    this.line.setAttribute('points', this.places().map((place) => place.join(',')).join(' ')); // prettier-ignore
  }

  /** The corners as drawn, pixels. */
  private places(): Place[] {
    const { corners, pointer } = this;
    if (!pointer || corners.length === 0) return corners;
    if (this.kind === 'polygon') return [...corners, pointer];
    const [[x, y]] = corners as [Place];
    return [[x, y], [pointer[0], y], pointer, [x, pointer[1]]]; // prettier-ignore
  }

  /** Give it up. */
  cancel(): void {
    this.svg.remove();
    this.corners = [];
    this.pointer = null;
    this.changed = true;
  }

  /** The outline in normalised device coordinates, or null while it encloses nothing. */
  outline(): [number, number][] | null {
    const places = this.places();
    if (places.length < 3) return null;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const step = Math.ceil(places.length / MOST);
    return places
      .filter((_, i) => i % step === 0)
      .map(([x, y]) => [(x / width) * 2 - 1, 1 - (y / height) * 2]);
  }

  /** Return the outline and remove it. */
  end(): [number, number][] | null {
    // The corner that follows the pointer is none that was set.
    if (this.kind === 'polygon') this.pointer = null;
    const outline = this.outline();
    this.cancel();
    return outline;
  }
}

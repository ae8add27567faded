/** Fingers on the canvas: two of them move the camera, and never paint. */

interface Finger {
  x: number;
  y: number;
}

/** Movement of two fingers since the last time. */
export interface Pinch {
  /** Their middle, and how far it moved, pixels. */
  readonly x: number;
  readonly y: number;
  readonly dx: number;
  readonly dy: number;
  /** Times farther apart. */
  readonly grown: number;
}

export class Touches {
  private readonly fingers = new Map<number, Finger>();

  /** A finger came down; true when it is the second or a further one. */
  down(event: PointerEvent): boolean {
    if (event.pointerType !== 'touch') return false;
    this.fingers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    return this.fingers.size > 1;
  }

  /** Move a finger; return the movement of the first two, or null unless it is one of them. */
  move(event: PointerEvent): Pinch | null {
    const finger = this.fingers.get(event.pointerId);
    if (!finger) return null;
    const before = this.span();
    finger.x = event.offsetX;
    finger.y = event.offsetY;
    const after = this.span();
    if (!before || !after) return null;
    const grown = before.apart > 1 ? after.apart / before.apart : 1;
    return { x: after.x, y: after.y, dx: after.x - before.x, dy: after.y - before.y, grown };
  }

  /** A finger went up; true while others are still down. */
  up(event: PointerEvent): boolean {
    this.fingers.delete(event.pointerId);
    return this.fingers.size > 0;
  }

  private span(): { x: number; y: number; apart: number } | null {
    const [one, other] = [...this.fingers.values()];
    if (!one || !other) return null;
    const apart = Math.hypot(one.x - other.x, one.y - other.y);
    return { x: (one.x + other.x) / 2, y: (one.y + other.y) / 2, apart };
  }
}

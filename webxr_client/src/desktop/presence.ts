/** Tells the others where the brush is: a few times a second, and only when it moved. */
import type { Vector3 } from 'three';
import type { Link } from '../net/link';
import { state } from '../state';

const PERIOD_MS = 100;

export class DeskPresence {
  private last = 0;
  private said = '';

  constructor(private readonly link: Link) {}

  /** `brush`: room coordinates, or null off the recording. */
  update(now: number, brush: Vector3 | null): void {
    if (now - this.last < PERIOD_MS || !state.sequence.peek()) return;
    this.last = now;
    const frame = state.frame.peek();
    const label = state.activeLabel.peek();
    const radius = state.brush.peek().radius;
    const place = brush && brush.toArray();
    const saying = JSON.stringify([frame, label, radius, place]);
    if (saying === this.said) return;
    this.said = saying;
    this.link.send({ type: 'presence', frame, label, radius, brush: place, head: null, hands: [] });
  }
}

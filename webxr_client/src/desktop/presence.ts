/** Sends the place of the brush to other people: a few times a second, and only after it moved. */
import type { Vector3 } from 'three';
import type { Link } from '../net/link';
import { peek } from '../store/watch';
import { state } from '../store/state';

const PERIOD_MS = 100;

export class DeskPresence {
  private last = 0;
  private lastSent = '';

  constructor(private readonly link: Link) {}

  /** `brush`: room coordinates, or null off the recording. */
  update(now: number, brush: Vector3 | null): void {
    if (now - this.last < PERIOD_MS || !peek(state.sequence)) return;
    this.last = now;
    const frame = peek(state.frame);
    const label = peek(state.activeLabel);
    const radius = peek(state.brush).radius;
    const place = brush && brush.toArray();
    const message = JSON.stringify([frame, label, radius, place]);
    if (message === this.lastSent) return;
    this.lastSent = message;
    this.link.send({ type: 'presence', frame, label, radius, brush: place, head: null, hands: [] });
  }
}

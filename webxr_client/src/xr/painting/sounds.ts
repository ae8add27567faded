/** Short sounds in place, by Web Audio: nothing is fetched. */
import { Quaternion, type Vector3 } from 'three';

/** Loudness of the strongest pulse's sound, of 1. */
const LOUDEST = 0.25;
/** A sound ends after this many seconds at least: shorter ones are clicks without a pitch. */
const SHORTEST = 0.03;
/** Hz: short pulses sound high, long ones low, as they feel. */
const [LOWEST, HIGHEST] = [140, 1300] as const;

/** Pitch of the sound for a pulse of so many milliseconds, Hz. */
export function pitchOf(milliseconds: number): number {
  return Math.min(HIGHEST, Math.max(LOWEST, 8000 / milliseconds));
}

/** Eyes in the scene: their place, and their rotation. */
export interface Listener {
  readonly head: Vector3;
  readonly turned: Quaternion;
}

export class Sounds {
  private context: AudioContext | null = null;
  private readonly back = new Quaternion();

  /** Sound like a pulse of this strength, 0..1, at a place of the scene. */
  play(strength: number, milliseconds: number, at: Vector3, { head, turned }: Listener): void {
    try {
      if (this.context && this.context.state !== 'running') {
        // Sounds that wait would all be heard at once.
        this.wake();
        return;
      }
      this.context ??= new AudioContext();
      // Heard from the head: ears at the origin that listen along −z.
      const place = at.clone().sub(head).applyQuaternion(this.back.copy(turned).invert());
      sound(this.context, strength, milliseconds, place);
    } catch {
      // A browser without sound: then there is the flash.
    }
  }

  /** Resume after the browser suspended it, as it does in the background; gestures are allowed to. */
  wake(): void {
    if (this.context?.state !== 'running') void this.context?.resume().catch(() => undefined);
  }

  dispose(): void {
    void this.context?.close().catch(() => undefined);
    this.context = null;
  }
}

function sound(context: AudioContext, strength: number, milliseconds: number, at: Vector3): void {
  const { currentTime: now, destination } = context;
  const end = now + Math.max(SHORTEST, milliseconds / 1000);
  const pitch = new OscillatorNode(context, { frequency: pitchOf(milliseconds) });
  const loudness = new GainNode(context, { gain: LOUDEST * strength });
  loudness.gain.exponentialRampToValueAtTime(1e-3 * LOUDEST, end);
  const place = new PannerNode(context, {
    panningModel: 'HRTF',
    positionX: at.x,
    positionY: at.y,
    positionZ: at.z,
  });
  pitch.connect(loudness).connect(place).connect(destination);
  pitch.start(now);
  pitch.stop(end);
}

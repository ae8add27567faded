/** Moving oneself: teleport by an arc, turn in steps, glide if one likes that better. */
import { free } from '../../common/free';
import { peek } from '../../store/watch';
import { DoubleSide, GLSL3, Mesh, MeshBasicMaterial, PlaneGeometry, RawShaderMaterial, RingGeometry, Vector3, type Object3D } from 'three'; // prettier-ignore
import { Switch } from '../input/pad';
import type { Pointer } from '../input/pointer';
import { Ribbon } from '../drawing/ribbon';
import type { Rig } from './rig';
import { xrSettings } from '../../store/xr-settings';
import { within } from '../drawing/vectors';

const SEGMENTS = 32;
/** Metres a second, and how fast that falls. */
const THROW = [6.5, 9.8] as const;
const STRAIGHT = [1000, 9.8] as const;
const FARTHEST = 12;
const GLIDE = 1.8;
/** Radians a second. */
const SPIN = 1.6;

/** Milliseconds for which the picture is black after a teleport, and until it is all there again. */
const BLINK = { black: 40, over: 100 } as const;

/** Return how dark a picture is so many milliseconds after a teleport, 0 to 1. */
export function blinkAt(since: number): number {
  const clear = (since - BLINK.black) / (BLINK.over - BLINK.black);
  return 1 - Math.min(1, Math.max(0, clear));
}

const VIGNETTE_VERTEX = /* glsl */ `
in vec3 position;
out vec2 place;
void main() {
  place = position.xy;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;

const VIGNETTE_FRAGMENT = /* glsl */ `
precision mediump float;
in vec2 place;
uniform float strength;
uniform float blink;
out vec4 result;
void main() {
  float dark = smoothstep(0.85 - 0.4 * strength, 1.25 - 0.4 * strength, length(place));
  result = vec4(0.0, 0.0, 0.0, max(blink, dark * strength));
}`;

export class Locomotion {
  private readonly arc = new Ribbon(SEGMENTS, { color: 0x5ea2ff, order: 70 });
  private readonly ring: Mesh<RingGeometry, MeshBasicMaterial>;
  private readonly vignette: Mesh<PlaneGeometry, RawShaderMaterial>;
  /** Count of jumps, and of pictures of gliding. */
  moves = 0;
  private aiming = false;
  private strength = 0;
  /** Milliseconds since one jumped. */
  private readonly sinceJump = Float64Array.of(BLINK.over);
  private readonly target = new Vector3();
  private readonly point = new Vector3();
  private readonly by = new Vector3();
  private readonly turns = new Switch();
  private readonly leanUp = new Switch();
  private valid = false;
  /** The next press goes where it points. */
  private isArmed = false;
  private pressed = false;

  constructor(private readonly rig: Rig) {
    const flat = new MeshBasicMaterial({ color: 0x5ea2ff, side: DoubleSide, depthTest: false });
    this.ring = new Mesh(new RingGeometry(0.16, 0.22, 40), flat);
    this.ring.rotation.x = -Math.PI / 2;
    const veil = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: VIGNETTE_VERTEX,
      fragmentShader: VIGNETTE_FRAGMENT,
      uniforms: { strength: { value: 0 }, blink: { value: 0 } },
      transparent: true,
      depthTest: false,
      depthWrite: false,
    });
    this.vignette = new Mesh(new PlaneGeometry(2, 2), veil);
    this.vignette.renderOrder = 80;
    for (const object of [this.ring, this.vignette]) {
      object.frustumCulled = false;
      object.visible = false;
    }
    this.ring.renderOrder = 70;
  }

  addTo(scene: Object3D): void {
    scene.add(this.arc.mesh, this.ring, this.vignette);
  }

  dispose(): void {
    this.arc.dispose();
    for (const object of [this.ring, this.vignette]) free(object);
  }

  /** Make the next press a teleport to its target, for inputs without a stick. */
  armTeleport(): void {
    this.isArmed = true;
    this.pressed = false;
  }

  /** A press is for going, not for painting. */
  get waits(): boolean {
    return this.isArmed;
  }

  /**
   * The hand that does not paint: lean forward to aim, let go to be there; sideways to turn.  `brush`
   * aims when that was asked for, unless it is `busy` with a panel.  `dragged`: the room moves in a hand.
   */
  update(
    hand: Pointer | null,
    brush: Pointer | null,
    busy: boolean,
    dragged: boolean,
    seconds: Float64Array,
  ): void {
    const { move, snap } = peek(xrSettings);
    const x = hand ? hand.pad.x : 0;
    const y = hand ? hand.pad.y : 0;
    const smooth = move === 'smooth' && hand?.device.pad === 'stick';
    const turning = this.turn(x, snap, seconds);
    const gliding = smooth && Math.abs(y) > 0;
    if (hand && gliding) this.glide(hand, y * seconds[0]!);
    else this.teleport(hand, smooth ? 0 : y);
    if (this.isArmed && !this.aiming) this.teleportOnRelease(busy ? null : brush);
    this.shade(gliding || turning || dragged, seconds);
  }

  /** In steps of `snap` degrees, or evenly when it is 0; true while it goes on. */
  private turn(x: number, snap: number, seconds: Float64Array): boolean {
    const step = this.turns.update(Math.abs(x)) === 1;
    if (this.aiming) return false;
    if (snap > 0) {
      if (step) this.rig.turn((-Math.sign(x) * snap * Math.PI) / 180);
      return false;
    }
    if (x !== 0) this.rig.turn(-x * SPIN * seconds[0]!);
    return x !== 0;
  }

  private glide(hand: Pointer, amount: number): void {
    this.by
      .copy(hand.direction)
      .setY(0)
      .normalize()
      .multiplyScalar(GLIDE * amount);
    this.rig.move(this.by);
    this.moves += 1;
  }

  private teleport(hand: Pointer | null, y: number): void {
    const edge = this.leanUp.update(Math.max(0, y));
    if (edge === 1) this.aiming = true;
    if (edge === -1) {
      if (this.aiming) this.moveToTarget();
      this.aiming = false;
    }
    this.aim(this.aiming ? hand : null);
  }

  /** The press that was asked for: aims while it is held or before, goes when it is let go. */
  private teleportOnRelease(brush: Pointer | null): void {
    this.aim(brush?.tracked === true ? brush : null);
    if (brush?.edge.click === 1) this.pressed = true;
    if (brush?.edge.click !== -1 || !this.pressed) return;
    this.isArmed = this.pressed = false;
    this.moveToTarget();
    this.aim(null);
  }

  private moveToTarget(): void {
    if (!this.valid) return;
    this.rig.moveTo(this.target);
    this.moves += 1;
    this.sinceJump[0] = 0;
  }

  private aim(hand: Pointer | null): void {
    if (hand) this.throwArc(hand);
    else this.valid = false;
    this.arc.show(hand ? SEGMENTS : 0);
    this.ring.visible = this.valid;
  }

  /** Down to the floor: thrown by a hand, straight on from the eyes. */
  private throwArc(hand: Pointer): void {
    const { origin, direction } = hand;
    const [speed, gravity] = hand.reach === 'far' ? STRAIGHT : THROW;
    const fall = direction.y * speed;
    const height = Math.max(0, origin.y);
    // Time at which the arc comes down to the floor.
    const flight = (fall + Math.sqrt(fall * fall + 2 * gravity * height)) / gravity;
    for (let i = 0; i < SEGMENTS; i++) {
      const t = (flight * i) / (SEGMENTS - 1);
      this.point.copy(origin).addScaledVector(direction, speed * t);
      this.point.y -= (gravity / 2) * t * t;
      this.arc.put(i, this.point.x, this.point.y, this.point.z);
    }
    this.target.copy(this.point).setY(0);
    this.valid = within(this.target, this.rig.head, FARTHEST);
    this.arc.paint(this.valid ? 0x5ea2ff : 0xff7b72);
    this.ring.position.copy(this.target).setY(0.01);
  }

  /** Narrow the view while it moves otherwise than by the head. */
  private shade(moving: boolean, seconds: Float64Array): void {
    const goal = moving && peek(xrSettings).vignette ? 1 : 0;
    this.strength += (goal - this.strength) * Math.min(1, seconds[0]! * 8);
    const { sinceJump, vignette } = this;
    const { uniforms } = vignette.material;
    const blink = blinkAt(sinceJump[0]!);
    sinceJump[0] = sinceJump[0]! + 1000 * seconds[0]!;
    vignette.visible = this.strength > 0.02 || blink > 0;
    uniforms['strength']!.value = this.strength;
    uniforms['blink']!.value = blink;
  }
}

/** The others: heads, hands, brushes and names, where they are in the recording's room. */
import {
  BoxGeometry,
  type BufferGeometry,
  ConeGeometry,
  Group,
  Mesh,
  MeshBasicMaterial,
  type MeshBasicMaterialParameters,
  type Object3D,
  Quaternion,
  SphereGeometry,
  Vector3,
} from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { Engine } from '../../engine/engine';
import { following } from '../../panels/people';
import { type Person, type Pose, state } from '../../store/state';
import { follow } from '../../store/watch';
import { faceEyes } from '../drawing/facing';
import { disposeModel } from '../input/model';
import { Sign } from '../drawing/sign';
import { SIZES } from '../drawing/sizes';
import { tint } from '../drawing/tint';

const FACING = { right: 0, up: 0, distance: SIZES.name.distance };
/** Looks of bodies: opaque colours, and translucent ones. */
const SOLID = { vertexColors: true, transparent: true };
const CLEAR = { ...SOLID, depthWrite: false };

/** Metres between eye and head below which the head would hide all else. */
const INSIDE = 0.25;

class Avatar {
  readonly group = new Group();
  private readonly head: Mesh;
  private readonly hands: Mesh[];
  private readonly brush: Mesh;
  private readonly name: Sign;
  /** Holds the name, and where that stands. */
  private readonly plate = new Group();
  private readonly above = new Vector3();
  private hasHead = false;

  constructor({ color, name }: Person) {
    const skull = tint(new SphereGeometry(0.11, 20, 14), color, 0.85);
    const glass = tint(new BoxGeometry(0.17, 0.08, 0.08), 0x0d1014).translate(0, 0.01, -0.08);
    this.head = body(mergeGeometries([glass, skull]), SOLID);
    for (const part of [skull, glass]) part.dispose();
    this.hands = [0, 1].map(() =>
      body(tint(new ConeGeometry(0.03, 0.11, 12), color, 0.85).rotateX(-Math.PI / 2), SOLID),
    );
    this.brush = body(tint(new SphereGeometry(1, 20, 14), color, 0.3), CLEAR);
    this.name = new Sign({ em: SIZES.name.em, order: 60 });
    this.name.write(name || 'Unnamed');
    this.plate.add(this.name.mesh);
    this.group.add(this.head, ...this.hands, this.brush, this.plate);
  }

  take(person: Person): void {
    place(this.head, person.head);
    this.hasHead = person.head !== null;
    this.hands.forEach((hand, i) => place(hand, person.hands[i] ?? null));
    this.brush.visible = person.brush !== null && person.radius > 0;
    if (person.brush) this.brush.position.set(...person.brush);
    this.brush.scale.setScalar(Math.max(0.005, person.radius));
    const { head, name, above } = this;
    name.mesh.visible = head.visible || this.brush.visible;
    above.copy(head.visible ? head.position : this.brush.position);
    above.y += head.visible ? 0.24 : person.radius + 0.08;
  }

  /** `eye` in the room, as all that is known of people. */
  face(eye: Vector3): void {
    const { head } = this;
    head.visible = this.hasHead && head.position.distanceToSquared(eye) > INSIDE * INSIDE;
    faceEyes(this.plate, this.above, eye, FACING);
  }

  /** This person's parts in the scene. */
  get seen(): { name: boolean; head: boolean; hands: number; brush: boolean } {
    const { name, head, brush } = this;
    const hands = this.hands.filter((hand) => hand.visible).length;
    return { name: name.mesh.visible, head: head.visible, hands, brush: brush.visible };
  }

  dispose(): void {
    this.name.dispose();
    disposeModel(this.group);
  }
}

function body(geometry: BufferGeometry, look: MeshBasicMaterialParameters): Mesh {
  const mesh = new Mesh(geometry, new MeshBasicMaterial(look));
  mesh.frustumCulled = false;
  return mesh;
}

function place(object: Object3D, pose: Pose | null): void {
  object.visible = pose !== null;
  if (!pose) return;
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[3], pose[4], pose[5], pose[6]);
}

/** Shows all people in `state.people`, also at the desk. */
export class People {
  private readonly avatars = new Map<string, Avatar>();
  /** The same, for every picture. */
  private present: readonly Avatar[] = [];
  private readonly eye = new Vector3();

  constructor(
    private readonly world: Group,
    changed: () => void,
  ) {
    follow(() => {
      const people = state.people.value;
      for (const [viewer, avatar] of this.avatars) {
        if (people.some((person) => person.viewer === viewer)) continue;
        avatar.dispose();
        this.avatars.delete(viewer);
      }
      for (const person of people) {
        let avatar = this.avatars.get(person.viewer);
        if (!avatar) {
          avatar = new Avatar(person);
          this.avatars.set(person.viewer, avatar);
          world.add(avatar.group);
        }
        avatar.take(person);
      }
      this.present = [...this.avatars.values()];
      changed();
    });
  }

  /** Visible parts of each person, for tests. */
  seen(): Avatar['seen'][] {
    return this.present.map((avatar) => avatar.seen);
  }

  /** Names turn to the eye, a place in the scene. */
  face(eye: Vector3): void {
    if (this.present.length === 0) return;
    this.world.worldToLocal(this.eye.copy(eye));
    for (let i = 0; i < this.present.length; i++) this.present[i]!.face(this.eye);
  }
}

/** Metres from the desk's camera to its target in the view of a person in a headset. */
const AHEAD = 1.5;

/** Bring the desk's camera to the eyes of the person followed. */
export function followPeople(engine: Engine): void {
  const eye = new Vector3();
  const target = new Vector3();
  const turn = new Quaternion();
  state.people.subscribe((people) => {
    const viewer = following.peek();
    if (viewer === null) return;
    const head = people.find((person) => person.viewer === viewer)?.head;
    if (!head) {
      following.value = null;
      return;
    }
    eye.set(head[0], head[1], head[2]);
    turn.set(head[3], head[4], head[5], head[6]);
    target.set(0, 0, -AHEAD).applyQuaternion(turn).add(eye);
    engine.camera.lookAt(eye, target, true);
    engine.viewer.invalidate();
  });
}

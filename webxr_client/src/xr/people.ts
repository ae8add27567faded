/** The others: heads, hands, brushes and names, where they are in the recording's room. */
import { effect } from '@preact/signals';
import { BoxGeometry, ConeGeometry, Group, Mesh, MeshBasicMaterial, SphereGeometry, type Object3D, type Vector3 } from 'three'; // prettier-ignore
import { state, type Person, type Pose } from '../state';
import { disposeModel } from './model';
import { Sign } from './sign';

class Avatar {
  readonly group = new Group();
  private readonly head = new Group();
  private readonly hands: Mesh[];
  private readonly brush: Mesh;
  private readonly name: Sign;

  constructor(person: Person) {
    const material = new MeshBasicMaterial({
      color: person.color,
      transparent: true,
      opacity: 0.85,
    });
    const visor = new MeshBasicMaterial({ color: 0x0d1014 });
    const skull = new Mesh(new SphereGeometry(0.11, 20, 14), material);
    const glass = new Mesh(new BoxGeometry(0.17, 0.08, 0.08), visor);
    glass.position.set(0, 0.01, -0.08);
    this.head.add(skull, glass);
    this.hands = [0, 1].map(() => {
      const hand = new Mesh(new ConeGeometry(0.03, 0.11, 12), material);
      hand.geometry.rotateX(-Math.PI / 2);
      return hand;
    });
    const glow = new MeshBasicMaterial({
      color: person.color,
      transparent: true,
      opacity: 0.3,
      depthWrite: false,
    });
    this.brush = new Mesh(new SphereGeometry(1, 20, 14), glow);
    this.name = new Sign({ em: 0.05, order: 60 });
    this.name.write(person.name || 'Someone');
    this.group.add(this.head, ...this.hands, this.brush, this.name.mesh);
  }

  take(person: Person): void {
    place(this.head, person.head);
    this.hands.forEach((hand, i) => place(hand, person.hands[i] ?? null));
    this.brush.visible = person.brush !== null && person.radius > 0;
    if (person.brush) this.brush.position.set(...person.brush);
    this.brush.scale.setScalar(Math.max(0.005, person.radius));
    const { head, name } = this;
    name.mesh.visible = head.visible || this.brush.visible;
    name.mesh.position.copy(head.visible ? head.position : this.brush.position);
    name.mesh.position.y += head.visible ? 0.24 : person.radius + 0.08;
  }

  face(eye: Vector3): void {
    this.name.mesh.lookAt(eye);
  }

  /** What one sees of this person. */
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

function place(object: Object3D, pose: Pose | null): void {
  object.visible = pose !== null;
  if (!pose) return;
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[3], pose[4], pose[5], pose[6]);
}

/** Shows everybody in `state.people`, at the desk too. */
export class People {
  private readonly avatars = new Map<string, Avatar>();
  /** The same, for every picture. */
  private present: readonly Avatar[] = [];
  private readonly unfollow: () => void;

  constructor(world: Group, changed: () => void) {
    this.unfollow = effect(() => {
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

  /** What one sees of each, for tests. */
  seen(): Avatar['seen'][] {
    return this.present.map((avatar) => avatar.seen);
  }

  /** Names turn to the eye. */
  face(eye: Vector3): void {
    for (let i = 0; i < this.present.length; i++) this.present[i]!.face(eye);
  }

  dispose(): void {
    this.unfollow();
    for (const avatar of this.avatars.values()) avatar.dispose();
    this.avatars.clear();
  }
}

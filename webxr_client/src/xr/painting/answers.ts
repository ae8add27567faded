/** Answers to a doubt on the ring of the hand that points at its piece. */
import { computed } from '@preact/signals';
import { Ray, Vector3 } from 'three';
import { FADED } from '../../engine/labels/colouring';
import { coloursOf } from '../../example/model';
import { answerable, answerDoubt, classifier, question } from '../../example/store';
import { state } from '../../store/state';
import { peek } from '../../store/watch';
import type { Pointer } from '../input/pointer';
import type { Answers } from '../input/up-down';
import type { Place } from './place';

/** A ray points at a piece that it passes within so many radii, or metres for each metre away. */
const [RADII, SLACK] = [2, 0.06];
const ray = new Ray();
const [centre, shift] = [new Vector3(), new Vector3()];

/** Up is the likelier class and then none of them, down the others; the middle answers nothing. */
const offered = computed((): Answers | null => {
  const place = question.value;
  if (!place || !answerable.value) return null;
  const [first, ...second] = place.classes as readonly [string, ...string[]];
  const others = classifier.value!.classes.filter((name) => !place.classes.includes(name));
  const named = [...second, ...others, null, first];
  const colours = coloursOf(named.map((name) => name ?? ''), state.palette.value); // prettier-ignore
  const list = named.map((name, k) => {
    return { id: k + 1, name: name ?? 'None of these', color: name === null ? FADED : colours[k]! };
  });
  return {
    list: [{ id: 0, name: 'Which class?', color: '#ffffff' }, ...list],
    take: (id) => question.peek() === place && answerDoubt(named[id - 1]),
  };
});

/** The answers, if the hand points at the piece that is asked about. */
export function answersAt(place: Place, hand: Pointer): Answers | null {
  const answers = peek(offered);
  if (!answers) return null;
  const { centre: at, radius } = peek(question)!;
  centre.fromArray(at).sub(shift.fromArray(peek(state.sequence)!.shift));
  place.toLocal(hand.origin, ray.origin);
  place.directionToLocal(hand.direction, ray.direction).normalize();
  const near = Math.max(RADII * radius, SLACK * centre.distanceTo(ray.origin));
  return ray.distanceToPoint(centre) <= near ? answers : null;
}

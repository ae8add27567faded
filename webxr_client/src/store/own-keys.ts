/** A person's own keys: this browser's copy of each account's, which the server keeps. */
import { computed, signal, type ReadonlySignal } from '@preact/signals';
import { keep, keptJson } from './kept';
import { state } from './state';
import { follow } from './watch';

/** Text of a command → key as the keyboard's table writes it. */
export type OwnKeys = Readonly<Record<string, string>>;

/** Former texts of commands → current ones: stored keys may have the former ones. */
const RENAMED: OwnKeys = {
  'Accept this frame': 'Mark this frame as checked',
  'Reject this frame': 'Mark this frame as to be corrected',
  'Confirm what is doubtful in this frame': 'Confirm the doubtful labels of this frame',
  'Hand in my task, and begin the next': 'Hand in my task and open the next',
  'Forget in and out points': 'Clear in and out points',
  'Paint with the shape chosen last': 'Paint with the last shape',
  'Stand the recording as found at import': 'Reset the floor to the import',
  'Follow what is painted: on or off': 'Follow painted labels: on or off',
  'Ghost of the frame before: show or hide': 'Ghost of the previous frame: show or hide',
  'Colour points by their own colour': 'Colour points by source colour',
  'Colour points by the direction of their surface': 'Colour points by surface direction',
  'Label by example: show or hide what is predicted':
    'Label by example: show or hide the prediction',
  'History: who changed what': 'History of edits',
  'Close the polygon; take what is in the box; the first answer to a doubt':
    'Close the polygon, take the points in the box, or choose the first class',
  'The second answer to a doubt': 'Choose the second class of a doubt',
  'By example: the next doubt': 'By example: next doubt',
  'The box onto the ground': 'Snap the box to the ground',
  'Use the tool in the middle of the picture': 'Use the tool at the centre of the view',
  'Take back the polygon’s last corner': 'Remove the polygon’s last corner',
  'Complete the stroke to an object; else the last label again':
    'Complete the stroke to an object, or return to the last label',
  'Clip to a box, or show everything': 'Clip to a box or show everything',
};

const place: ReadonlySignal<string> = computed(
  () => `pointbrush.keys.${state.me.value?.account ?? ''}`,
);
const chosen = signal<OwnKeys>({});
export const ownKeys: ReadonlySignal<OwnKeys> = chosen;

/** As printed → the key that a person has in its place: for tooltips. */
export const renamedKeys = signal<ReadonlyMap<string, string>>(new Map());

/** Keys that a person chose since the page opened, for the server to store; null: none. */
export const keysToStore = signal<OwnKeys | null>(null);

follow(() => {
  chosen.value = withNewWords(read());
  keysToStore.value = null;
});

function read(): OwnKeys {
  const found = keptJson(place.value) ?? {};
  return Object.fromEntries(Object.entries(found).filter(([, key]) => typeof key === 'string'));
}

function withNewWords(keys: OwnKeys): OwnKeys {
  return Object.fromEntries(
    Object.entries(keys).map(([command, key]) => [RENAMED[command] ?? command, key]),
  );
}

/** Give a command a key, which another one loses; null: its own again. */
export function setKey(command: string, key: string | null): void {
  const others = Object.entries(chosen.peek()).filter(
    ([what, held]) => what !== command && held !== key,
  );
  change(Object.fromEntries(key === null ? others : [...others, [command, key]]));
}

export function resetKeys(): void {
  change({});
}

/** Take the keys that the server keeps. */
export function takeKeys(keys: OwnKeys): void {
  chosen.value = withNewWords(keys);
  keep(place.peek(), JSON.stringify(chosen.peek()));
}

function change(keys: OwnKeys): void {
  takeKeys(keys);
  keysToStore.value = keys;
}

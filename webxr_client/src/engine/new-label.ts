/** A label whose name is typed while the server makes it. */
import { signal } from '@preact/signals';
import { actions } from '../actions';
import { suggestColor, suggestName } from '../panels/colors';
import { canEdit, state } from '../state';

export interface NewLabel {
  readonly name: string;
  readonly color: string;
  /** 0 until the server has made it. */
  readonly id: number;
}

/** The label that is being named, or null. */
export const newLabel = signal<NewLabel | null>(null);

type Create = (name: string, color: string) => Promise<number>;

let made: Promise<number> = Promise.resolve(0);

/** Show a name to type over, and ask the server for the label meanwhile. */
export async function beginLabel(create: Create): Promise<void> {
  if (!canEdit.peek() || newLabel.peek()) return;
  const palette = state.palette.peek();
  const names = palette.map((label) => label.name);
  const colors = palette.map((label) => label.color);
  const draft: NewLabel = { name: suggestName('', names), color: suggestColor(colors), id: 0 };
  newLabel.value = draft;
  made = create(draft.name, draft.color);
  const id = await made;
  if (newLabel.peek() === draft) newLabel.value = id === 0 ? null : { ...draft, id };
}

/** Take the name that was typed; null gives the label up. */
export async function finishLabel(name: string | null): Promise<void> {
  const draft = newLabel.peek();
  if (!draft) return;
  newLabel.value = null;
  const id = await made;
  if (id === 0) return;
  if (name === null) await actions.deleteLabel(id);
  else if (name !== '' && name !== draft.name) await actions.renameLabel(id, name);
}

/** Whether an entry of the palette is the label that is being named: its row is the field's. */
export function isNew(draft: NewLabel | null, label: NewLabel): boolean {
  if (draft === null) return false;
  if (draft.id !== 0) return label.id === draft.id;
  return label.name === draft.name && label.color === draft.color;
}

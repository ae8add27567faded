/** Labels that become one, and one that becomes several. */
import type { Actions } from '../actions';
import { api } from '../net/rest';
import { notify, state } from '../state';
import { attempt } from './recordings';

function pathOf(label: number): string {
  const sequence = encodeURIComponent(state.sequence.peek()?.id ?? '');
  return `sequences/${sequence}/labels/${label}`;
}

function nameOf(id: number): string {
  return state.palette.peek().find((label) => label.id === id)?.name ?? 'the label';
}

function merge(id: number, into: number): Promise<void> {
  const [from, to] = [nameOf(id), nameOf(into)];
  return attempt('The labels were not merged', async () => {
    await api('POST', `${pathOf(into)}/merge`, { labels: [id] });
    state.activeLabel.value = into;
    notify('success', `“${from}” is part of “${to}” now`, 'In every frame. Undo brings it back.');
  });
}

function split(id: number): Promise<void> {
  const frame = state.frame.peek();
  return attempt(`“${nameOf(id)}” was not split`, async () => {
    const { labels } = await api<{ labels: number[] }>('POST', `${pathOf(id)}/split`, { frame });
    notify(
      'success',
      `“${nameOf(id)}” is in ${labels.length + 1} parts now`,
      'The largest keeps the name. Track the new ones on from this frame.',
    );
  });
}

export const partActions: Pick<Actions, 'mergeLabel' | 'splitLabel'> = {
  mergeLabel: merge,
  splitLabel: split,
};

/** A person's own keys as the server keeps them, for every browser of theirs. */
import { untracked } from '@preact/signals';
import { api } from '../../net/rest';
import type { OwnKeys as KeysAnswer } from '../../protocol/values';
import { keysToStore, type OwnKeys, ownKeys, takeKeys } from '../../store/own-keys';
import { state } from '../../store/state';
import { follow } from '../../store/watch';
import { attempt } from '../recordings/recordings';

const PATH = 'me/keys';

/** Load the keys of the signed-in account, and store its changes. */
export function followOwnKeys(): void {
  let known: string | null = null;
  follow(() => {
    const account = state.me.value?.account ?? null;
    if (account === null || account === known) return;
    known = account;
    void untracked(load).catch(() => (known = null)); // requested again with the next welcome
  });
  follow(() => {
    const keys = keysToStore.value;
    if (keys !== null) void attempt('Your keys are stored only in this browser', () => put(keys));
  });
}

async function load(): Promise<void> {
  const { keys } = await api<KeysAnswer>('GET', PATH);
  if (keysToStore.peek() !== null) return; // changed during the request
  if (keys !== null) takeKeys(keys);
  else if (Object.keys(ownKeys.peek()).length > 0) await put(ownKeys.peek());
}

function put(keys: OwnKeys): Promise<void> {
  return api('PUT', PATH, { keys });
}

/** Sign out: end this browser's session. */
import { api } from '../../net/rest';
import { notify, state } from '../../store/state';
import { attempt } from '../recordings/recordings';

/** End the session and go to the page of the sign-out; not while edits wait to be stored. */
export async function signOut(): Promise<void> {
  if (state.pending.peek() > 0) {
    notify(
      'error',
      'Not signed out',
      'Edits are still being sent to the server. Try again when they are saved.',
    );
    return;
  }
  await attempt('Not signed out', async () => {
    await api('DELETE', 'session');
    location.assign(new URL('?sign-in=out', document.baseURI));
  });
}

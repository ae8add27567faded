/** The page without an open recording: connecting, no recordings, or the list of recordings. */
import { refreshDeleted, restoreSequence } from '../../engine/recordings/recordings';
import { useSignal } from '@preact/signals';
import { useEffect, useState } from 'preact/hooks';
import { signOut } from '../../engine/people/sign-out';
import { actions } from '../../store/actions';
import { canManage, state } from '../../store/state';
import { Button } from '../parts/controls';
import { PopoverButton } from '../parts/popover';
import { studyCode } from '../../common/checking';
import { day, plural } from '../../common/format';
import { Icon } from '../../common/icons';
import { api, apiUrl } from '../../net/rest';
import { Recordings } from './home';
import { ImportBox } from './import-box';

export function Welcome() {
  const { state: connection, detail } = state.connection.value;
  const sequences = state.sequences.value;
  if (connection === 'refused') return <Refused detail={detail} />;
  if (studyCode() !== null) return null;
  if (state.opening.value !== null) return <Waiting text="Opening the recording…" />;
  if (sequences === null) {
    return connection === 'offline' ? <Offline detail={detail} /> : <Waiting text="Connecting…" />;
  }
  const empty = sequences.length === 0;
  return (
    <div class={empty ? 'welcome-page empty' : 'welcome-page'}>
      {empty ? (
        <div class="welcome-box stack">
          <Empty />
          <ImportBox />
        </div>
      ) : (
        <Recordings sequences={sequences} />
      )}
      <footer class="home-foot line wrap spread soft small">
        <span>
          {!empty && canManage.value && 'Drop files or a folder anywhere to import them.'}
        </span>
        <Deleted />
        <Account />
      </footer>
    </div>
  );
}

/** The account that is signed in and its role, with a button to sign out. */
function Account() {
  const me = state.me.value;
  return (
    me && (
      <span class="line">
        <span>
          Signed in as <b>{me.author}</b>, {me.role}
        </span>
        <Button label="Sign out" small onClick={() => void signOut()} />
      </span>
    )
  );
}

function Waiting({ text }: { text: string }) {
  return (
    <div class="center" role="status">
      <div class="spinner" />
      <h1 class="soft waiting">{text}</h1>
    </div>
  );
}

/** Reasons for a missing session, by their names in the address. */
const REASONS: Readonly<Record<string, string>> = {
  failed: 'The sign-in failed. Try again.',
  out: 'Your edits are stored.',
  forbidden: 'Your account has no access to this workspace. Ask a manager of the workspace.',
};

function Refused({ detail }: { detail: string }) {
  const [provider, setProvider] = useState<string | null>(null);
  useEffect(() => {
    const none = (): void => undefined;
    api<{ name: string | null }>('GET', 'oidc').then(({ name }) => setProvider(name), none);
  }, []);
  const reason = new URL(location.href).searchParams.get('sign-in') ?? '';
  const title = provider === null ? 'This link does not open the workspace' : 'Sign in';
  const missing = 'The token in the address is missing, expired or wrong.';
  return (
    <div class="center message" role="alert">
      <Icon name="lock" />
      <h1>{reason === 'out' ? 'You are signed out' : title}</h1>
      <p>{REASONS[reason] ?? (detail || missing)}</p>
      {provider !== null && (
        <a class="button primary" href={apiUrl('oidc/login')}>
          Sign in with {provider}
        </a>
      )}
      <p class="soft">
        Use the address that <code>pointbrush serve</code> printed, or ask for a new one.
      </p>
    </div>
  );
}

function Offline({ detail }: { detail: string }) {
  return (
    <div class="center message" role="alert">
      <Icon name="offline" />
      <h1>The server does not answer</h1>
      <p>{detail || 'The server may be stopped, or the network is down.'}</p>
      <Button label="Try again" kind="primary" onClick={() => actions.page.reconnect()} />
    </div>
  );
}

function Empty() {
  return (
    <header>
      <h1>No recordings yet</h1>
      <p class="soft">
        Import a recording: a folder or a set of point clouds, one file per frame, in the order of
        their names.
      </p>
    </header>
  );
}

/** Recordings that were deleted and can be brought back. */
function Deleted() {
  const open = useSignal(false);
  const { value: deleted } = state.deleted;
  useEffect(() => void refreshDeleted(), []);
  if (deleted.length === 0) return null;
  return (
    <PopoverButton
      open={open}
      icon="trash"
      button={{ label: plural(deleted.length, 'deleted recording'), class: 'small' }}
      tip="Recordings that can be restored"
      label="Deleted recordings"
    >
      <ul>
        {deleted.map((row) => (
          <li key={row.identity} class="line">
            <strong class="name">{row.name}</strong>
            <span class="soft">
              Deleted {day(row.deleted)} · kept until {day(row.until)}
            </span>
            <Button
              icon="restore"
              label="Restore"
              kind="outlined"
              small
              disabled={!canManage.value}
              onClick={() => void restoreSequence(row.identity)}
            />
          </li>
        ))}
      </ul>
    </PopoverButton>
  );
}

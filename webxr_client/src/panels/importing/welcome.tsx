/** Before a recording is open: connecting, nothing there yet, or the list of what there is. */
import { useEffect, useState } from 'preact/hooks';
import { importEach, importInto, projects } from '../../engine/projects';
import { signOut } from '../../engine/sign-out';
import { actions } from '../../store/actions';
import { canManage, state } from '../../store/state';
import { Button, Check } from '../parts/controls';
import { day, plural } from '../../common/format';
import { Icon } from '../../common/icons';
import { api, apiUrl } from '../../net/rest';
import { pickFiles } from './files';
import { Recordings } from './home';

export function Welcome() {
  const { state: connection, detail } = state.connection.value;
  const sequences = state.sequences.value;
  if (connection === 'refused') return <Refused detail={detail} />;
  if (state.opening.value !== null) return <Waiting text="Opening the recording…" />;
  if (sequences === null) {
    return connection === 'offline' ? <Away detail={detail} /> : <Waiting text="Connecting…" />;
  }
  return (
    <div class="welcome-page">
      <div class="welcome-box">
        {sequences.length > 0 ? <Recordings sequences={sequences} /> : <Empty />}
        <ImportBox />
        <Deleted />
        <Account />
      </div>
    </div>
  );
}

/** The account that is signed in and its role, with a button to sign out. */
function Account() {
  const me = state.me.value;
  return (
    me && (
      <footer class="account soft">
        <span>
          Signed in as <b>{me.author}</b>, {me.role}
        </span>
        <Button label="Sign out" onClick={() => void signOut()} />
      </footer>
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

/** Reasons why there is no session, as the address has them. */
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

function Away({ detail }: { detail: string }) {
  return (
    <div class="center message" role="alert">
      <Icon name="offline" />
      <h1>The server does not answer</h1>
      <p>{detail || 'The server may be stopped, or the network is down.'}</p>
      <Button label="Try again" kind="primary" onClick={() => actions.reconnect()} />
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
  const [shown, setShown] = useState(false);
  const { value: deleted } = state.deleted;
  useEffect(() => void actions.refreshDeleted(), []);
  if (deleted.length === 0) return null;
  return (
    <section aria-label="Deleted recordings">
      <Button
        icon="trash"
        label={plural(deleted.length, 'deleted recording')}
        expanded={shown}
        onClick={() => setShown(!shown)}
      />
      {shown && (
        <ul class="recordings">
          {deleted.map((row) => (
            <li key={row.identity} class="recording">
              <Icon name="trash" />
              <strong class="name">{row.name}</strong>
              <span class="soft">
                Deleted {day(row.deleted)} · kept until {day(row.until)}
              </span>
              <Button
                icon="restore"
                label="Restore"
                kind="outlined"
                disabled={!canManage.value}
                onClick={() => void actions.restoreSequence(row.identity)}
              />
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}

function ImportBox() {
  const [path, setPath] = useState('');
  const [each, setEach] = useState(false);
  const submit = (event: Event): void => {
    event.preventDefault();
    if (!path.trim()) return;
    if (each) void importEach(path.trim(), importInto.peek());
    else void actions.importPath(path.trim());
  };
  return (
    <section class="import-box" aria-label="Import">
      <div class="drop-hint">
        <Icon name="import" />
        <p>
          <strong>Drop files or a folder here</strong>
          <span class="soft">PLY, PCD, LAS, LAZ, E57, NPZ, KITTI, XYZ, bags and more</span>
        </p>
        <div class="group">
          <Button label="Choose files" kind="primary" onClick={() => pickFiles()} />
          <Button label="Choose a folder" kind="outlined" onClick={() => pickFiles(true)} />
        </div>
      </div>
      <form class="path-form" onSubmit={submit}>
        <label>
          <span class="soft">Or a path on the server</span>
          <input
            class="field"
            value={path}
            placeholder="/data/recordings/session-12"
            spellcheck={false}
            onInput={(event) => setPath(event.currentTarget.value)}
          />
        </label>
        <button type="submit" class="button outlined" disabled={!path.trim()}>
          Import
        </button>
      </form>
      <div class="import-into">
        <Check
          label="Import each file or folder in it as a recording"
          checked={each}
          onChange={setEach}
        />
        {projects.value.length > 1 && <Into />}
      </div>
      <p class="soft">
        In a terminal: <code>pointbrush import PATH…</code>
      </p>
    </section>
  );
}

/** The project that recordings come into, by files and by path. */
function Into() {
  return (
    <label class="soft">
      Into project
      <select
        class="field"
        value={importInto.value}
        onChange={(event) => (importInto.value = event.currentTarget.value)}
      >
        {projects.value.map(({ id, name }) => (
          <option key={id} value={id}>
            {name}
          </option>
        ))}
      </select>
    </label>
  );
}

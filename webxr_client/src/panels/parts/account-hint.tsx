/** Names of accounts for a field, a warning about unknown ones, and the link of a new token. */
import { useEffect } from 'preact/hooks';
import {
  accounts,
  createAccount,
  isUnknown,
  loadAccounts,
  newLink,
} from '../../engine/people/accounts';
import { notify } from '../../store/state';
import { Button } from './controls';

interface AccountHintProps {
  /** Id of the list of names, for the field. */
  id: string;
  /** The typed name, or empty. */
  name: string;
  role?: string;
  /** Whether the link of a new account is shown here, and not beside the list of accounts. */
  link?: boolean;
}

/** Names for a field that asks for an account, and a warning when no account has the typed name. */
export function AccountHint({ id, name, role = 'annotator', link = true }: AccountHintProps) {
  useEffect(() => void loadAccounts(), []);
  const typed = name.trim();
  return (
    <>
      <datalist id={id}>
        {(accounts.value ?? []).map(({ account }) => (
          <option key={account} value={account} />
        ))}
      </datalist>
      {isUnknown(typed) && (
        <p class="note line wrap" role="status">
          No account with access is called “{typed}”.
          <Button
            label="Create account"
            kind="outlined"
            small
            onClick={() => void createAccount(typed, role)}
          />
        </p>
      )}
      {link && newLink.value?.account === typed && <NewLink />}
    </>
  );
}

/** The link of a new token, with a button that copies it. */
export function NewLink() {
  const made = newLink.value;
  if (!made) return null;
  const copy = (): void =>
    void navigator.clipboard.writeText(made.link).then(
      () => notify('success', `Link of ${made.account} copied`),
      () => notify('error', 'The link was not copied', 'Select it and copy it by hand.'),
    );
  return (
    <p class="note line wrap" role="status">
      Sign-in link of {made.account}, shown only once: <code>{made.link}</code>
      <Button label="Copy" kind="outlined" small onClick={copy} />
    </p>
  );
}

/** Accounts of the workspace, for managers. */
import type { Account } from '../protocol/values';
import { useEffect, useState } from 'preact/hooks';
import { plural } from '../common/format';
import {
  accounts,
  addToken,
  createAccount,
  newLink,
  revokeAccess,
} from '../engine/people/accounts';
import { NewLink } from '../panels/parts/account-hint';
import { Button, SureButton } from '../panels/parts/controls';
import { RoleSelect } from './role-select';

export function WorkspaceAccounts() {
  const [name, setName] = useState('');
  const [role, setRole] = useState('annotator');
  useEffect(() => () => void (newLink.value = null), []);
  const submit = (event: Event): void => {
    event.preventDefault();
    void createAccount(name.trim(), role).then(() => setName(''));
  };
  const all = accounts.value ?? [];
  return (
    <section class="settings-webhook" aria-label="Accounts of the workspace">
      <h3>Accounts of the workspace</h3>
      {all.length === 0 && <p class="soft">No accounts yet. Each person needs one.</p>}
      <ul class="settings-rows stack" tabIndex={0} aria-label="Accounts">
        {all.map((each) => (
          <Entry key={each.account} of={each} />
        ))}
      </ul>
      <NewLink />
      <form class="settings-add" onSubmit={submit}>
        <input
          class="field"
          aria-label="Name of the new account"
          placeholder="Name of the new account"
          maxLength={128}
          value={name}
          onInput={(event) => setName(event.currentTarget.value)}
        />
        <RoleSelect of="the new account" value={role} onChange={setRole} />
        <Button submit label="Create account" kind="outlined" disabled={!name.trim()} />
      </form>
    </section>
  );
}

function Entry({ of: { account, role, tokens } }: { of: Account }) {
  const valid = tokens.filter((token) => token.valid).length;
  return (
    <li>
      <strong class="name">{account}</strong>
      <span class="soft">{role ? `${role} · ${plural(valid, 'token')}` : 'no access'}</span>
      <Button
        icon="plus"
        tip={`New token for ${account}`}
        small
        onClick={() => void addToken(account)}
      />
      <SureButton
        label="Revoke"
        tip={`Revoke all tokens of ${account}`}
        disabled={!role}
        onClick={() => void revokeAccess(account)}
      />
    </li>
  );
}

/** Accounts of the workspace for managers, and the requests that change them. */
import { signal } from '@preact/signals';
import { api } from '../../net/rest';
import type { Account, NewToken } from '../../protocol/values';
import { attempt } from '../recordings/recordings';

/** null until the server has answered. */
export const accounts = signal<readonly Account[] | null>(null);
/** The link of the newest token; the server shows a token once. */
export const newLink = signal<{ readonly account: string; readonly link: string } | null>(null);

export const loadAccounts = (): Promise<void> =>
  attempt('The accounts did not load', async () => {
    accounts.value = await api<Account[]>('GET', 'accounts');
  });

/** Whether a typed name, which may be empty, is of no account with access. */
export function isUnknown(name: string): boolean {
  const known = accounts.value?.some(({ account, role }) => account === name && role !== null);
  return name !== '' && known === false;
}

async function make(path: string, body: object): Promise<void> {
  await attempt('The token was not created', async () => {
    const { account, token } = await api<NewToken>('POST', path, body);
    newLink.value = { account, link: new URL(`/?token=${token}`, document.baseURI).href };
  });
  await loadAccounts();
}

export function createAccount(account: string, role: string): Promise<void> {
  return make('accounts', { account, role });
}

export function addToken(account: string): Promise<void> {
  return make(tokensOf(account), {});
}

/** Revoke all tokens of an account. */
export async function revokeAccess(account: string): Promise<void> {
  await attempt('The access was not revoked', async () => {
    await api('DELETE', tokensOf(account));
    if (newLink.peek()?.account === account) newLink.value = null;
  });
  await loadAccounts();
}

function tokensOf(account: string): string {
  return `accounts/${encodeURIComponent(account)}/tokens`;
}

/** The settings of a project: its name, and a tab for each kind of settings. */
import type { ProjectInfo } from '../protocol/values';
import { useEffect, useState } from 'preact/hooks';
import { settled } from '../engine/recordings/projects';
import { Button, Check } from '../panels/parts/controls';
import { useModal } from '../panels/parts/modal';
import { Tabs, tabId } from '../panels/parts/tabs';
import { AccountHint } from '../panels/parts/account-hint';
import { WorkspaceAccounts } from './accounts-list';
import { HeadsetReports } from './headset-reports';
import { RoleSelect } from './role-select';
import {
  deleteProject,
  loadTaxonomy,
  save,
  selectCategory,
  secret,
  setRole,
  settledProject,
  type SettingsTab,
  settingsTab,
  TABS,
  taxonomy,
} from './settings';
import { Recordings, ProjectTasks } from './settings-work';
import { Webhooks } from './webhooks';

const BODIES: Readonly<Record<SettingsTab, (props: { of: ProjectInfo }) => preact.JSX.Element>> = {
  people: People,
  categories: Categories,
  recordings: Recordings,
  tasks: ProjectTasks,
  webhooks: Webhooks,
};

export function ProjectSettings() {
  const of = settledProject.value;
  const open = of !== null;
  const dialog = useModal(open);
  useEffect(() => {
    if (!open) secret.value = null;
  }, [open]);
  if (!of) return null;
  const close = (): void => void (settled.value = null);
  const Body = BODIES[settingsTab.value];
  return (
    <dialog ref={dialog} class="settings" aria-label="Settings of the project" onClose={close}>
      <header class="line spread">
        <input
          class="field"
          aria-label="Name of the project"
          maxLength={200}
          value={of.name}
          onChange={({ currentTarget }) => {
            const name = currentTarget.value.trim();
            if (name) void save({ name });
            else currentTarget.value = of.name;
          }}
        />
        {of.recordings.length === 0 && (
          <Button icon="trash" tip="Delete this project" onClick={() => void deleteProject()} />
        )}
        <Button icon="close" tip="Close the settings" onClick={close} />
      </header>
      <Tabs
        label="Settings"
        tabs={TABS}
        chosen={settingsTab.value}
        onChoose={(tab) => (settingsTab.value = tab)}
      />
      <div
        class="settings-body stack"
        role="tabpanel"
        aria-labelledby={tabId('Settings', settingsTab.value)}
        key={of.id}
      >
        <Body of={of} />
      </div>
    </dialog>
  );
}

function People({ of }: { of: ProjectInfo }) {
  const [account, setAccount] = useState('');
  const [role, setNewRole] = useState('annotator');
  const rows = Object.entries(of.roles).sort();
  const submit = (event: Event): void => {
    event.preventDefault();
    if (account.trim()) void setRole(account.trim(), role);
    setAccount('');
  };
  return (
    <>
      <p class="soft">
        {rows.length === 0
          ? 'All members have access with their role in the workspace. The first person that you add restricts the project to the people listed here.'
          : 'Only these people and managers of the workspace see the project. A person with a lower role in the workspace keeps the lower role.'}
      </p>
      <ul class="settings-rows stack">
        {rows.map(([name, own]) => (
          <li key={name} class="line">
            <strong class="name">{name}</strong>
            <RoleSelect of={name} value={own} onChange={(next) => void setRole(name, next)} />
            <Button
              icon="close"
              tip={`Remove ${name} from the project`}
              small
              onClick={() => void setRole(name, null)}
            />
          </li>
        ))}
      </ul>
      <form class="line" onSubmit={submit}>
        <input
          class="field grow"
          aria-label="Account"
          placeholder="Account name"
          maxLength={128}
          list="settings-people"
          value={account}
          onInput={(event) => setAccount(event.currentTarget.value)}
        />
        <RoleSelect of="the new person" value={role} onChange={setNewRole} />
        <Button submit label="Add" kind="primary" disabled={!account.trim()} />
      </form>
      <AccountHint id="settings-people" name={account} role={role} link={false} />
      <WorkspaceAccounts />
      <HeadsetReports />
    </>
  );
}

function Categories({ of: { categories } }: { of: ProjectInfo }) {
  useEffect(() => void loadTaxonomy(), []);
  const all = taxonomy.value;
  return (
    <>
      <p class="soft">
        {all.length === 0
          ? 'The workspace has no categories yet. An export or import of labels adds their categories.'
          : 'New labels can have only these categories; existing labels keep theirs. The numbers belong to the workspace.'}
      </p>
      {categories !== null && (
        <Button
          label={`All ${all.length} and future categories`}
          kind="outlined"
          onClick={() => void save({ categories: null })}
        />
      )}
      <div class="settings-categories halves">
        {all.map(({ number, name }) => (
          <Check
            key={number}
            label={`${number} ${name}`}
            checked={categories?.includes(number) ?? true}
            onChange={(on) => void selectCategory(number, on)}
          />
        ))}
      </div>
    </>
  );
}

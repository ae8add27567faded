/** The Work panel at the side: tasks, findings, frames, agreement and versions of a project. */
import { Button } from '../panels/parts/controls';
import { tabId, Tabs } from '../panels/parts/tabs';
import { state } from '../store/state';
import { AgreementTab } from './agreement';
import { Findings } from './findings';
import { Frames } from './frames';
import { marked, pointing } from './places';
import { waiting } from './review';
import { openWork, project, tabs, workOpen, workTab, type WorkTab } from './store';
import { Tasks } from './tasks';
import { Versions } from './versions';

const TABS: Readonly<Record<WorkTab, readonly [words: string, Body: () => preact.ComponentChild]>> = {
  tasks: ['Tasks', Tasks],
  findings: ['Findings', Findings],
  frames: ['Frames', Frames],
  agreement: ['Agreement', AgreementTab],
  versions: ['Versions', Versions],
}; // prettier-ignore

const isShown = (): boolean =>
  workOpen.value && state.sequence.value !== null && state.xr.value.session !== 'running';

function close(): void {
  workOpen.value = false;
  marked.value = pointing.value = null;
}

export function WorkPanel() {
  if (!isShown()) return null;
  const tab = workTab.value;
  const [, Body] = TABS[tab];
  return (
    <>
      <header class="panel-head line spread">
        <h2 class="name">{project.value ? `Project ${project.value.name}` : 'Work'}</h2>
        <Button icon="close" tip="Close the panel" small onClick={close} />
      </header>
      <Tabs
        label="Work"
        tabs={tabs.value.map((each) => [
          each,
          TABS[each][0],
          each === 'findings' ? waiting.value.length : 0,
        ])}
        chosen={tab}
        onChoose={openWork}
      />
      <div class="work-body stack" role="tabpanel" aria-labelledby={tabId('Work', tab)}>
        <Body />
      </div>
    </>
  );
}

export function WorkButton() {
  const open = workOpen.value;
  return (
    <Button
      icon="check"
      label="Work"
      tip="Tasks, findings, states of frames, agreement, versions"
      pressed={open}
      onClick={() => (open ? close() : openWork())}
    />
  );
}

/** Tasks and versions of a project, at the side, in the place of the review. */
import { render } from 'preact';
import { Button } from '../panels/parts/controls';
import { Tabs } from '../panels/parts/tabs';
import { bindActions } from '../store/actions';
import { state } from '../store/state';
import { follow } from '../store/watch';
import { begin, followTeam, openTeam, project, teamOpen, teamTab, type TeamTab } from './store';
import { AgreementTab } from './agreement';
import { followCopies } from './copies';
import { may, Tasks } from './tasks';
import { Versions } from './versions';

const TABS: readonly (readonly [TeamTab, string])[] = [
  ['tasks', 'Tasks'],
  ['agreement', 'Agreement'],
  ['versions', 'Versions'],
];
const BODIES = { tasks: Tasks, agreement: AgreementTab, versions: Versions };

const close = (): void => {
  teamOpen.value = false;
};

function TeamPanel() {
  if (!teamOpen.value || !state.sequence.value) return null;
  if (state.xr.value.session === 'running') return null;
  const of = project.value;
  const tabs = TABS.filter(([tab]) => tab !== 'agreement' || (of && may(of, 'reviewer')));
  const Body = BODIES[teamTab.value];
  return (
    <>
      <header>
        <h2>{project.value?.name ?? 'Tasks'}</h2>
        <Button icon="close" tip="Close the tasks" small onClick={close} />
      </header>
      <Tabs label="Tasks, agreement or versions" tabs={tabs} chosen={teamTab} />
      <div class="review-body">
        <Body />
      </div>
    </>
  );
}

/** Opens the tasks. */
export function TeamButton() {
  const open = teamOpen.value;
  return (
    <Button
      icon="people"
      label="Tasks"
      tip="Tasks of the project: mine, the next, all by person"
      pressed={open}
      onClick={() => (open ? close() : openTeam())}
    />
  );
}

/** Put the panel beside the stage; the result takes it away again. */
export function mountTeam(): () => void {
  const app = document.getElementById('app')!;
  const place = document.createElement('aside');
  place.id = 'team';
  place.setAttribute('aria-label', 'Tasks');
  document.getElementById('stage')!.after(place);
  render(<TeamPanel />, place);
  const stops = [
    followTeam(),
    followCopies(),
    bindActions({ nextTask: (of) => begin(of) }),
    follow(() => {
      const open = teamOpen.value && state.sequence.value !== null;
      app.classList.toggle('teaming', open && state.xr.value.session !== 'running');
    }),
  ];
  return () => {
    for (const stop of stops) stop();
    render(null, place);
    place.remove();
  };
}

/** The page beside a checked headset: tasks, their results, and the report. */
import { useState } from 'preact/hooks';
import { actions } from '../store/actions';
import { Button } from '../panels/parts/controls';
import { Icon } from '../common/icons';
import { canEdit, state } from '../store/state';
import { ready } from './recording';
import { saveReport } from './report';
import type { Findings } from './round';
import { outcomeOf, TASKS } from './tasks';

const WORDS = { works: 'works', fails: 'fails', unknown: 'not tried' } as const;

export function CheckPage({ findings }: { findings: Findings }) {
  const [closed, close] = useState(false);
  const { session } = state.xr.value;
  if (session === 'running' || closed) return null;
  return (
    <section class="check-headset card" aria-labelledby="check-title">
      <h2 id="check-title">Check this headset</h2>
      <p class="soft">
        Enter VR and follow the panel before you; this takes ten minutes. You paint in a recording
        made for the check. When you leave VR, the page sends a report to this server. It lists the
        abilities of the headset and its controllers. It contains no points and no names.
      </p>
      <ul>
        {TASKS.map(({ name, title }) => (
          <li key={name}>
            <span>{title}</span>
            <span class="soft">{WORDS[outcomeOf(name).verdict]}</span>
          </li>
        ))}
      </ul>
      <Trouble />
      <footer class="line">
        <Button label="Close" onClick={() => close(true)} />
        <span class="spacer" />
        <Button label="Download the report" kind="outlined" onClick={() => saveReport(findings)} />
        <Button
          icon="headset"
          label="Enter to check"
          kind="primary"
          disabled={!ready.value || state.xr.value.supported !== true || session !== 'none'}
          onClick={() => void actions.page.enterVR()}
        />
      </footer>
    </section>
  );
}

/** Reasons why one cannot enter, or not do everything. */
function Trouble() {
  const { detail } = state.xr.value;
  const words = [
    detail,
    ready.value ? '' : 'The recording for the check is being prepared.',
    canEdit.value ? '' : 'This token has the role viewer: painting cannot be checked.',
  ].filter((each) => each !== '');
  return words.map((each) => (
    <p key={each} role="status">
      <Icon name="warning" /> {each}
    </p>
  ));
}

/** Steps of a participant that are read and answered at the desk, in a dialog over the page. */
import { apiUrl } from '../net/rest';
import { Button } from '../panels/parts/controls';
import { useModal } from '../panels/parts/modal';
import type { StudyStep } from '../protocol/values';
import { actions } from '../store/actions';
import { state } from '../store/state';
import { NextButton } from './bar';
import { Questions } from './questions';
import { activeStep, isTask, isWorn, PAUSED } from './step';

export function StudyCards() {
  const step = activeStep.value;
  const worn = state.xr.value.session === 'running';
  if (!step || worn || (isTask(step) && !isWorn(step))) return null;
  return <Card key={`${step.number} ${step.kind}`} step={step} />;
}

/** A step is left by its own button only. */
function stay(event: Event): void {
  if (!(event instanceof KeyboardEvent) || event.key === 'Escape') event.preventDefault();
}

function Card({ step }: { step: StudyStep }) {
  const dialog = useModal();
  const questionnaire = step.kind === 'questionnaire' && step.questionnaire;
  return (
    <dialog ref={dialog} class="settings" aria-label={step.title} onCancel={stay} onKeyDown={stay}>
      <header class="line soft">{step.title}</header>
      <div class="settings-body stack">
        {questionnaire ? <Questions of={questionnaire} /> : <Reading step={step} />}
      </div>
    </dialog>
  );
}

/** Return heading, text and the button's words of a step that is read. */
function wordsOf({ kind, task, text }: StudyStep): [title: string, text: string, next: string] {
  if (kind === 'consent') return ['Before you begin', text, 'I agree'];
  if (kind === 'pause') return ['Paused', PAUSED, ''];
  if (kind === 'done') return ['Thank you', 'The study is finished. You can close this page.', ''];
  return [task?.name ?? 'Instructions', text, 'Begin'];
}

function Reading({ step }: { step: StudyStep }) {
  const { task, sequence, start } = step;
  const [title, text, next] = wordsOf(step);
  const worn = isWorn(step);
  const thumbnail = sequence && apiUrl(`sequences/${sequence}/frames/${start}/thumbnail`);
  const picture = task?.picture || thumbnail;
  return (
    <>
      <h2>{worn ? `${title}: put on the headset` : title}</h2>
      {text.split(/\n\s*\n/).map((each) => (
        <p key={each}>{each}</p>
      ))}
      {next && picture && <img src={picture} alt="" style={{ maxWidth: '100%' }} />}
      <footer class="form-end">
        {worn ? <EnterButton /> : next && <NextButton label={next} />}
      </footer>
    </>
  );
}

function EnterButton() {
  const { supported, session, detail } = state.xr.value;
  return (
    <>
      {supported === false && <p class="note grow">{detail}</p>}
      <Button icon="headset" label="Enter VR" kind="primary" disabled={!supported || session === 'starting'}
        onClick={() => void actions.page.enterVR()} />
    </>
  ); // prettier-ignore
}

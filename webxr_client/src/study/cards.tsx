/** Steps of a participant that are read and answered at the desk, in a dialog over the page. */
import type { ComponentChildren } from 'preact';
import { apiUrl } from '../net/rest';
import { Button } from '../panels/parts/controls';
import { useModal } from '../panels/parts/modal';
import type { StudyStep } from '../protocol/values';
import { actions } from '../store/actions';
import { state } from '../store/state';
import { Questions } from './questions';
import { activeStep, finish, finishing, isTask, isWorn } from './step';

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
  return (
    <dialog ref={dialog} class="settings" aria-label={step.title} onCancel={stay} onKeyDown={stay}>
      <header class="line soft">{step.title}</header>
      <div class="settings-body stack">
        <Content step={step} />
      </div>
    </dialog>
  );
}

function Content({ step }: { step: StudyStep }) {
  const next = (label: string) => (
    <Button label={label} kind="primary" disabled={finishing.value} onClick={() => void finish([])} />
  ); // prettier-ignore
  const { kind, task, questionnaire } = step;
  if (isWorn(step))
    return <Reading title={`${task?.name}: put on the headset`} step={step} foot={<EnterButton />} />; // prettier-ignore
  if (kind === 'consent')
    return <Reading title="Before you begin" step={step} foot={next('I agree')} />;
  if (kind === 'instructions')
    return <Reading title={task?.name ?? 'Instructions'} step={step} foot={next('Begin')} />;
  if (kind === 'pause')
    return <Reading title="Paused" words="The study continues in a moment. Your work is kept." />;
  if (kind === 'done')
    return <Reading title="Thank you" words="The study is finished. You can close this page." />;
  return questionnaire && <Questions of={questionnaire} />;
}

interface ReadingProps {
  title: string;
  step?: StudyStep;
  words?: string;
  foot?: ComponentChildren;
}

/** A heading, paragraphs, and the picture of the task. */
function Reading({ title, step, words = step?.text ?? '', foot }: ReadingProps) {
  const { task, sequence, start } = step ?? {};
  const thumbnail = sequence && apiUrl(`sequences/${sequence}/frames/${start}/thumbnail`);
  const picture = task?.picture || thumbnail;
  return (
    <>
      <h2>{title}</h2>
      {words.split(/\n\s*\n/).map((each) => (
        <p key={each}>{each}</p>
      ))}
      {picture && <img src={picture} alt="" style={{ maxWidth: '100%' }} />}
      <footer class="form-end">{foot}</footer>
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

/** Bar at the bottom of the canvas: the found people, and the next step with them. */
import { leavePeople, peopleOffer, peopleStep } from '../../engine/find-people';
import { Icon } from '../../common/icons';
import { Button, Swatch } from '../parts/controls';
import { exportOpen } from '../parts/popover';

export function PeopleBar() {
  const offer = peopleOffer.value;
  const step = peopleStep.value;
  // While tracking runs, its own card shows the progress and stops it.
  if (!offer || !step || step.at === 'tracking') return null;
  const { text, busy, main, leave } = offer;
  return (
    <section class="bar card line wrap" role="status" aria-label="Find people">
      {busy ? <span class="spinner small" /> : <Icon name="people" />}
      <span>{text}</span>
      {step.people.map(({ name, color }) => (
        <span key={name} class="soft">
          <Swatch color={color} /> {name}
        </span>
      ))}
      {main && <Button icon={main.icon} label={main.text} kind="primary" keys="Enter" disabled={main.disabled} onClick={main.run} />}
      {main?.icon === 'export' && <Button label="Other formats…" kind="outlined" onClick={() => (exportOpen.value = leavePeople())} />}
      <Button label={leave} keys="Esc" onClick={leavePeople} />
    </section>
  ); // prettier-ignore
}

/** Opens the review. */
import { Button } from '../panels/controls';
import { closeReview, reviewOpen } from './store';

export function ReviewButton() {
  const open = reviewOpen.value;
  return (
    <Button
      icon="check"
      label="Review"
      tip="Suspicious labels, states and notes, people, agreement, report"
      pressed={open}
      onClick={() => (open ? closeReview() : (reviewOpen.value = true))}
    />
  );
}

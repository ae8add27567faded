/** Actions of the box tool, in the tool bar. */
import { actions } from '../actions';
import { boxDraft } from '../tools/box-draft';
import { Button } from './controls';

export function BoxOptions() {
  if (!boxDraft.value) return <span class="hint">Drag over the floor</span>;
  return (
    <>
      <Button
        icon="plane"
        label="Onto the ground"
        kind="outlined"
        tip="Its bottom just above the ground under it"
        keys="Shift G"
        onClick={() => actions.snapBox()}
      />
      <Button
        icon="check"
        label="Take"
        kind="primary"
        tip="Take the points in the box"
        keys="Enter"
        onClick={() => actions.closeOutline()}
      />
    </>
  );
}

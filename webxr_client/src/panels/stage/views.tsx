/** Top right of the canvas: views, and the object or person that the camera follows. */
import { signal } from '@preact/signals';
import { actions, type ViewPreset } from '../../store/actions';
import { orthographic } from '../../view/framing';
import type { Bookmark } from '../../store/types';
import { bookmarks, removeBookmark, renameBookmark } from '../../view/bookmarks';
import { followsObject } from '../../view/going';
import { Button } from '../parts/controls';
import { PopoverButton } from '../parts/popover';

const VIEWS: readonly (readonly [ViewPreset, string, string, string])[] = [
  ['sensor', 'Sensor', 'Look from the position of the sensor', 'R'],
  ['top', 'Top', 'Plan from above, to scale', 'T'],
  ['front', 'Front', 'Elevation from the front, to scale', ''],
  ['left', 'Side', 'Elevation from the side, to scale', ''],
  ['fit', 'Fit', 'Show everything', ''],
];

const bookmarksOpen = signal(false);

export function Views() {
  return (
    <div class="views small" role="group" aria-label="View">
      {VIEWS.map(([preset, name, tip, keys]) => (
        <Button
          key={preset}
          label={name}
          tip={tip}
          keys={keys || undefined}
          onClick={() => actions.view.viewFrom(preset)}
        />
      ))}
      <span class="divider" />
      <Button
        icon="view"
        tip="Orthographic: parallel lines stay parallel"
        keys="P"
        pressed={orthographic.value}
        onClick={() => actions.view.toggleOrthographic()}
      />
      <Button
        icon="target"
        tip="Go to the active label’s object"
        keys="F"
        onClick={() => actions.view.goToObject()}
      />
      <Button
        icon="track"
        tip="Follow the active label’s object from frame to frame"
        pressed={followsObject.value}
        onClick={() => (followsObject.value = !followsObject.value)}
      />
      <PopoverButton
        open={bookmarksOpen}
        icon="bookmark"
        tip="Saved views"
        label="Saved views"
        class="form"
      >
        <Bookmarks />
      </PopoverButton>
    </div>
  );
}

/** Views that were kept: go to one, rename it, drop it. */
function Bookmarks() {
  return (
    <>
      {bookmarks.value.map((one, index) => (
        <Row key={`${index} ${one.name}`} one={one} index={index} />
      ))}
      {bookmarks.value.length === 0 && (
        <p class="soft">A saved view restores camera position, direction and frame.</p>
      )}
      <Button
        icon="plus"
        label="Save this view"
        kind="outlined"
        onClick={() => actions.view.keepView()}
      />
    </>
  );
}

function Row({ one, index }: { one: Bookmark; index: number }) {
  return (
    <div class="line">
      <Button icon="target" tip={`Go to ${one.name}`} onClick={() => actions.view.goToView(one)} />
      <input
        class="field grow"
        aria-label="Name of the view"
        defaultValue={one.name}
        maxLength={80}
        onKeyDown={(event) => event.key !== 'Escape' && event.stopPropagation()}
        onChange={(event) => renameBookmark(index, event.currentTarget.value)}
      />
      <span class="soft number">frame {one.frame}</span>
      <Button icon="trash" tip={`Delete ${one.name}`} onClick={() => removeBookmark(index)} />
    </div>
  );
}

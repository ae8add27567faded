/** The strip of cameras beside the cloud: pictures with the frame's points in their labels' colours. */
import { computed } from '@preact/signals';
import { useLayoutEffect } from 'preact/hooks';
import { largeCamera, pictures, stripOpen } from '../../cameras/state';
import { state } from '../../store/state';
import { Button } from '../parts/controls';
import { CameraPicture } from './camera-picture';

/** Whether the recording has pictures: their room is kept from the start. */
const pictured = computed(
  () => state.sequence.value?.cameras || (pictures.value?.cameras.length ?? 0) > 0,
);
/** Whether the strip is open: pictures of a depth camera's own colours must be asked for. */
const open = computed(
  () => pictured.value && (stripOpen.value ?? state.sequence.value?.cameras === true),
);

/** In the tool bar's second row, where the recording has pictures. */
export function CamerasButton() {
  if (!pictured.value) return null;
  return (
    <Button
      icon="camera"
      {...(state.sequence.value?.cameras && { label: 'Pictures' })}
      tip="Pictures of the cameras, with the points in them"
      pressed={open.value}
      onClick={() => (stripOpen.value = !open.value)}
    />
  );
}

export function CameraPanel() {
  const found = pictures.value;
  useLayoutEffect(() => {
    const stage = document.getElementById('stage')!;
    stage.classList.toggle('with-cameras', open.value);
    return () => stage.classList.remove('with-cameras');
  }, [open.value]);
  if (!open.value) return null;
  const cameras = found?.cameras ?? [];
  const large = cameras.find(({ name }) => name === largeCamera.value);
  return (
    <>
      <section class="cameras" aria-label="Cameras">
        {cameras.map((picture) => (
          <CameraPicture key={picture.name} picture={picture} large={false} />
        ))}
        {found && cameras.length === 0 && <p class="soft empty">No picture of this frame.</p>}
      </section>
      {large && (
        <section class="camera-large" aria-label={`Camera ${large.name}, large`}>
          <CameraPicture key={large.name} picture={large} large />
        </section>
      )}
    </>
  );
}

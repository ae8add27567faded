/** Sensors of a recording of several, in the tool bar and over the picture: shown or hidden. */
import { signal } from '@preact/signals';
import { aligned, aligning, alignSensors } from '../../engine/align-sensors';
import { colourBySensor, hiddenSensors, sensors, showSensor } from '../../store/sensors';
import { canEdit, canManage, state } from '../../store/state';
import { Button, Check, Swatch } from '../parts/controls';
import { PopoverButton } from '../parts/popover';

const open = signal(false);

/** In the tool bar's second row. */
export function SensorsButton() {
  if (sensors.value.length === 0) return null;
  return (
    <PopoverButton
      open={open}
      icon="sensors"
      tip="Sensors"
      pressed={hiddenSensors.value.size > 0}
      label="Sensors"
      class="stack"
    >
      {sensors.value.map(({ number, name, kind, color }) => (
        <Check
          key={number}
          label={
            <>
              <Swatch color={color} /> {name} <span class="soft">{kind}</span>
            </>
          }
          checked={!hiddenSensors.value.has(number)}
          onChange={(on) => showSensor(number, on)}
        />
      ))}
      <Check
        label="Colour by sensor"
        checked={state.view.value.color === 'sensor'}
        onChange={colourBySensor}
      />
      {canManage.value && (
        <div class="line">
          <Button
            kind="outlined"
            label="Align sensors"
            tip="Correct the mounts by surfaces that several sensors see"
            disabled={aligning.value}
            onClick={() => void alignSensors()}
          />
          {aligned.value && (
            <Button
              icon="undo"
              label="Undo"
              tip="Restore the mounts of before the last alignment"
              disabled={aligning.value}
              onClick={() => void alignSensors(true)}
            />
          )}
        </div>
      )}
    </PopoverButton>
  );
}

/** Sign over the picture while sensors are hidden. */
export function SensorsSign() {
  const hidden = sensors.value.filter(({ number }) => hiddenSensors.value.has(number));
  if (hidden.length === 0) return null;
  return (
    <div class="sign line" role="status">
      <span>
        {hidden.map(({ name }) => name).join(', ')} hidden: only points of the other sensors are
        shown
        {canEdit.value && <strong> and painted</strong>}
      </span>
      <Button
        icon="close"
        small
        tip="Show all sensors"
        onClick={() => (hiddenSensors.value = new Set())}
      />
    </div>
  );
}

/** Fields of forms, lists to choose from, and tables. */
import type { ComponentChildren, ComponentProps } from 'preact';

interface RowProps {
  label: string;
  tip?: string;
  children: ComponentChildren;
}

/** A control with its label before it. */
export function Row({ label, tip, children }: RowProps) {
  return (
    <label class="row" data-tip={tip}>
      <span>{label}</span>
      {children}
    </label>
  );
}

/** A list to choose from with its label before it. */
export function ChoiceRow<T extends string>(props: ChoiceProps<T> & { label: string }) {
  const { label, tip, ...choice } = props;
  return (
    <Row label={label} {...(tip !== undefined && { tip })}>
      <Choice {...choice} />
    </Row>
  );
}

type FieldProps = ComponentProps<'input'> & { label: string; tip?: string };

/** A field with its label above it. */
export function Field({ label, tip, ...input }: FieldProps) {
  return (
    <label data-tip={tip}>
      {label}
      <input class="field" {...input} />
    </label>
  );
}

interface ChoiceProps<T extends string> {
  value: T;
  /** Value and text of each. */
  choices: readonly (readonly [value: T, words: string, ...rest: unknown[]])[];
  /** Its name, where no label is beside it. */
  label?: string;
  tip?: string;
  class?: string;
  disabled?: boolean;
  onChange: (value: T) => void;
}

/** A list to choose from; with an empty value it resets after a choice, which starts an action. */
export function Choice<T extends string>(props: ChoiceProps<T>) {
  const { value, choices, label, tip, class: extra = '', onChange } = props;
  return (
    <select
      class={`field ${extra}`}
      aria-label={label}
      data-tip={tip}
      value={value}
      disabled={props.disabled}
      onChange={({ currentTarget }) => {
        const chosen = currentTarget.value as T;
        if (value === '') currentTarget.value = value;
        onChange(chosen);
      }}
    >
      {choices.map(([id, words]) => (
        <option key={id} value={id}>
          {words}
        </option>
      ))}
    </select>
  );
}

interface TableProps {
  /** Heading of each column, and its tooltip. */
  head: readonly (readonly [words: string, tip?: string])[];
  rows: readonly (readonly ComponentChildren[])[];
  class?: string;
}

export function Table({ head, rows, class: extra }: TableProps) {
  return (
    <table class={extra}>
      <thead>
        <tr>
          {head.map(([words, tip]) => (
            <th key={words} data-tip={tip}>
              {words}
            </th>
          ))}
        </tr>
      </thead>
      <tbody class="number">
        {rows.map((cells, row) => (
          <tr key={row}>
            {cells.map((cell, column) => (
              <td key={column}>{cell}</td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

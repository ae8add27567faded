/** Choice of a role; roles above the own one are not offered, as the server refuses them. */
import { Choice } from '../panels/parts/fields';
import { ROLES, state } from '../store/state';

interface RoleSelectProps {
  of: string;
  value: string;
  onChange: (role: string) => void;
}

export function RoleSelect({ of, value, onChange }: RoleSelectProps) {
  const own = ROLES.indexOf(state.me.value?.role ?? 'admin');
  const offered = ROLES.filter((role, rank) => rank <= own || role === value);
  return (
    <Choice
      label={`Role of ${of}`}
      value={value}
      choices={offered.map((role) => [role, role] as const)}
      onChange={onChange}
    />
  );
}

"""Accounts, their roles, tokens, sign-ins and keys."""

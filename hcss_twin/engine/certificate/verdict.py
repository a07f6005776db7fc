"""The certificate's verdict on the whole scene: what is left out, and the error against the world."""

from __future__ import annotations

from dataclasses import replace

from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.plan.error_budget import beyond_accuracy, error_budget
from hcss_twin.plan.plan import Plan


def with_verdict(plan: Plan, certificate: Certificate) -> Certificate:
    """Return the certificate with what the plan leaves out, and the budget with the achieved error of the engine."""
    budget = error_budget(plan, certificate.achieved)
    return replace(certificate, beyond=beyond_accuracy(plan, budget), budget=budget)

from .job_file import Job, load_job
from .running import RunReport, VerifyReport, run, verify

__all__ = [
    "Job",
    "RunReport",
    "VerifyReport",
    "load_job",
    "run",
    "verify",
]

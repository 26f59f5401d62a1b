.PHONY: demo test coverage docs dist
demo test coverage docs dist:
	@bash run.sh $@
